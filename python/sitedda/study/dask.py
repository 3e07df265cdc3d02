# SPDX-License-Identifier: GPL-3.0-or-later
"""A Dask cluster as the executor of the cases.

Anyone who can connect to a scheduler can run any code on its workers and clients.  Use TLS, or a
network that only trusted users can access.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from ..base.errors import InputError, OutputError


@contextmanager
def dask_client(address: str, ca: str = "", certificate: str = "", key: str = "") -> Iterator:
    """Yield a client of a scheduler, and close the client at the end.

    `address`: such as ``tcp://host:8786``, or ``tls://host:8786`` with the following files.
    `ca`, `certificate`, `key`: PEM files of TLS: certificate of the authority, certificate and key
    of the client.
    """
    try:
        from distributed import Client
        from distributed.security import Security
    except ImportError as error:
        text = "--dask needs the package distributed: pip install sitedda[study]"
        raise InputError(text) from error
    if bool(certificate) != bool(key) or (certificate and not ca):
        raise InputError("TLS needs all three: --tls-ca, --tls-cert, --tls-key")
    if certificate and not address.startswith("tls://"):
        raise InputError(f"{address!r}: with TLS, the address must begin with tls://")
    security = None
    if certificate:
        security = Security(tls_ca_file=ca, tls_client_cert=certificate, tls_client_key=key,
                            require_encryption=True)  # fmt: skip
    try:
        client = Client(address, security=security, timeout=20)
    except (OSError, ValueError, TimeoutError) as error:
        raise OutputError(f"no Dask scheduler responds at {address}: {error}") from error
    try:
        yield client
    finally:
        client.close()
