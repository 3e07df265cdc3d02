// SPDX-License-Identifier: GPL-3.0-or-later
// Read {grammar, text} as JSON; write [word, innermost scope] of each token in Visual Studio Code.
const fs = require("fs"), oniguruma = require("vscode-oniguruma"), textmate = require("vscode-textmate");

async function main({ grammar, text }) {
  await oniguruma.loadWASM(fs.readFileSync(require.resolve("vscode-oniguruma/release/onig.wasm")).buffer);
  const onigLib = Promise.resolve({
    createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
    createOnigString: (line) => new oniguruma.OnigString(line),
  });
  const registry = new textmate.Registry({ onigLib, loadGrammar: async () => grammar });
  const tokenizer = await registry.loadGrammar(grammar.scopeName);
  const tokens = [];
  let state = textmate.INITIAL;
  for (const line of text.split("\n")) {
    const found = tokenizer.tokenizeLine(line, state);
    state = found.ruleStack;
    for (const { startIndex, endIndex, scopes } of found.tokens)
      tokens.push([line.slice(startIndex, endIndex), scopes.at(-1)]);
  }
  console.log(JSON.stringify(tokens));
}
main(JSON.parse(fs.readFileSync(0, "utf8")));
