// The connection to the server: it sends the token, unpacks messages, and reconnects after a loss.

const AGAIN = 1500;  // ms between attempts
const REFUSED = 4401;

/** Streams of a message, by name, as views of the bytes of the message. */
class MessageStreams {
  constructor(buffer, base, places) {
    Object.assign(this, {buffer, base, places});
  }

  has(name) {
    return name in this.places;
  }

  deflated(name) {
    const [at, length] = this.places[name];
    return new Uint8Array(this.buffer, this.base + at, length);
  }

  floats(name) {
    const [at, length] = this.places[name];
    return new Float32Array(this.buffer, this.base + at, length / 4);
  }

  integers(name) {
    const [at, length] = this.places[name];
    return new Int32Array(this.buffer, this.base + at, length / 4);
  }
}

function unpacked(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return [head, new MessageStreams(buffer, 4 + length, head.streams)];
}

/** Return the token: move it from the address into the storage, which all tabs share. */
function token() {
  if (location.hash.length > 1) {
    localStorage.setItem("token", location.hash.slice(1));
    history.replaceState(null, "", location.pathname);
  }
  return localStorage.getItem("token") || "";
}

export class Link {
  /** `onMessage` receives (head, streams); `onState` receives "refused" or "lost". */
  constructor(onMessage, onState) {
    this.onMessage = onMessage;
    this.onState = onState;
    window.addEventListener("storage", (event) => { if (event.key === "token") this.connect(); });
    window.addEventListener("hashchange", () => this.connect());
  }

  enter(word) {
    localStorage.setItem("token", word);
    this.connect();
  }

  connect() {
    clearTimeout(this.later);
    const before = this.socket;
    this.socket = null;
    if (before) before.close();
    const word = token();
    if (!word) {
      this.onState("refused");
      return;
    }
    const socket = new WebSocket(`ws://${location.host}/socket`);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.addEventListener("open", () => {
      socket.send(JSON.stringify({token: word}));
    });
    socket.addEventListener("message", ({data}) => {
      if (socket !== this.socket) return;
      if (typeof data === "string") this.onMessage(JSON.parse(data), null);
      else this.onMessage(...unpacked(data));
    });
    socket.addEventListener("close", ({code}) => {
      if (socket !== this.socket) return;
      if (code === REFUSED) {
        localStorage.removeItem("token");
        this.onState("refused");
        return;
      }
      this.onState("lost");
      this.later = setTimeout(() => this.connect(), AGAIN);
    });
  }

  /** Send a command and its fields; return whether there is a connection. */
  ask(command, fields = {}) {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({do: command, ...fields}));
    return true;
  }
}
