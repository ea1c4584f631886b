"""Who may attach from another machine, and what a component shows to be let in: certificates, users and passwords."""

from __future__ import annotations

import secrets
import socket
import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

_PATIENCE = 1.0
"""how long a look at a connection may take [s]; a refusal of our certificate comes within a round trip"""


class CredentialsError(Exception):
    """A certificate, key, user or password that cannot be used."""


@dataclass(frozen=True, kw_only=True)
class Credentials:
    """What a component shows to the orchestrator, and whom it takes for the orchestrator."""

    authority: Path | None = None
    """certificates (PEM) of those who may sign the orchestrator's; none: the well-known public ones"""
    certificate: Path | None = None
    """its own certificate (PEM), where the orchestrator asks for one"""
    key: Path | None = None
    """the private key of `certificate` (PEM, without a passphrase)"""
    user: str | None = None
    """its name, where the orchestrator asks for one"""
    password: str | None = None
    """the password of `user`"""

    def settings(self) -> dict[str, object]:
        """Zenoh's settings for them.

        Raises:
            CredentialsError: if a file or a counterpart is missing, or the key is that of another certificate.
        """
        _check_couple("--certificate", self.certificate, "--key", self.key)
        if (self.user is None) != (self.password is None):
            raise CredentialsError(
                "a user without a password, or a password without a user: give --user with --password-file, "
                "or $CROWDCOSIM_USER with $CROWDCOSIM_PASSWORD"
            )
        settings: dict[str, object] = {}
        if self.authority:
            _check_pem("--authority", self.authority, "CERTIFICATE")
            settings["transport/link/tls/root_ca_certificate"] = str(self.authority)
        if self.certificate:
            settings["transport/link/tls/enable_mtls"] = True
            settings["transport/link/tls/connect_certificate"] = str(self.certificate)
            settings["transport/link/tls/connect_private_key"] = str(self.key)
        if self.user is not None:
            settings["transport/auth/usrpwd/user"] = self.user
            settings["transport/auth/usrpwd/password"] = self.password
        return settings


@dataclass(frozen=True, kw_only=True)
class Admission:
    """Where the orchestrator lets components in from outside, and whom."""

    listen: str
    """endpoint, such as tls/0.0.0.0:7450 or, unprotected, tcp/0.0.0.0:7450"""
    certificate: Path | None = None
    """the orchestrator's certificate (PEM), for TLS"""
    key: Path | None = None
    """its private key (PEM, without a passphrase)"""
    authority: Path | None = None
    """if given, components must show a certificate that was signed by one of these (PEM)"""
    users: Path | None = None
    """if given, components must show one of these: a file of lines `user:password`"""

    def settings(self) -> dict[str, object]:
        """Zenoh's settings for TLS.

        Raises:
            CredentialsError: if a file is missing or not what it should be, or the key is that of another certificate.
        """
        _check_couple("attach.certificate", self.certificate, "attach.key", self.key)
        settings: dict[str, object] = {}
        if self.certificate:
            settings["transport/link/tls/listen_certificate"] = str(self.certificate)
            settings["transport/link/tls/listen_private_key"] = str(self.key)
        if self.authority:
            _check_pem("attach.authority", self.authority, "CERTIFICATE")
            settings["transport/link/tls/root_ca_certificate"] = str(self.authority)
            settings["transport/link/tls/enable_mtls"] = True
        return settings

    def passwords(self) -> dict[str, str]:
        """User -> password, of the file `users`.

        Raises:
            CredentialsError: if it cannot be read, or a line is none of `user:password`.
        """
        if self.users is None:
            return {}
        passwords: dict[str, str] = {}
        for number, line in enumerate(_read("attach.users", self.users).splitlines(), 1):
            if line.strip():
                user, colon, password = line.strip().partition(":")
                if not (user and colon and password):
                    raise CredentialsError(f"attach.users: {self.users}:{number}: expected a line `user:password`")
                passwords[user] = password
        if not passwords:
            raise CredentialsError(f"attach.users: {self.users} has no user, expected lines `user:password`")
        return passwords

    def demands(self) -> str:
        """What a component must show, in words; empty if nothing."""
        demands = []
        if self.authority:
            demands.append(f"a certificate signed by {self.authority.name}")
        if self.users:
            demands.append(f"a user of {self.users.name}")
        return " and ".join(demands)


def stranger() -> tuple[str, str]:
    """A user and a password that nobody else has, for the processes that the orchestrator starts itself."""
    return f"local-{secrets.token_hex(8)}", secrets.token_hex(16)


class Obstacle(NamedTuple):
    """Why there is no session."""

    text: str
    lasting: bool
    """whether it makes no sense to try again"""


def obstacle(endpoint: str, shown: Credentials) -> Obstacle:
    """Why no session could be opened, as far as one look at the endpoint tells; Zenoh itself does not say."""
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.rpartition(":")
    host = host.strip("[]")
    if protocol not in ("tcp", "tls") or not host or not port.isdecimal():
        return Obstacle("expected an endpoint such as tls/192.0.2.1:7450", True)
    try:
        with socket.create_connection((host, int(port)), _PATIENCE) as link:
            refusal = _look_at_tls(link, host, shown) if protocol == "tls" else None
    except socket.gaierror as error:
        return Obstacle(f"there is no host '{host}': {error.strerror}", False)
    except OSError as error:
        return Obstacle(f"nobody answers: {error.strerror or error}", False)
    return Obstacle(refusal or _refused_user(shown), True)


def _look_at_tls(link: socket.socket, host: str, shown: Credentials) -> str | None:
    """Shake hands as the session would have done; why it fails."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    if shown.authority:
        context.load_verify_locations(shown.authority)
    else:
        context.load_default_certs()
    if shown.certificate:
        context.load_cert_chain(shown.certificate, shown.key)
    try:
        with context.wrap_socket(link, server_hostname=host) as secured:
            return _late_refusal(secured, shown)
    except ssl.SSLCertVerificationError as error:
        whose = f"signed by {shown.authority}" if shown.authority else "signed by a public authority; give --authority"
        return f"the orchestrator's certificate is refused: {error.verify_message}; expected one for '{host}', {whose}"
    except ssl.SSLError as error:
        return _refused_certificate(error.reason or str(error), shown)
    except OSError as error:
        return f"no TLS is spoken there ({error.strerror or error}); is it a tcp endpoint?"


def _late_refusal(secured: ssl.SSLSocket, shown: Credentials) -> str | None:
    """With TLS 1.3 our certificate is refused after the handshake; who is content keeps silent."""
    try:
        secured.recv(1)
    except TimeoutError:
        return None
    except ssl.SSLError as error:
        return _refused_certificate(error.reason or str(error), shown)
    except OSError as error:
        return f"the orchestrator breaks off: {error.strerror or error}"
    return None


def _refused_certificate(reason: str, shown: Credentials) -> str:
    if "ALERT" not in reason:
        return f"no TLS is spoken there ({reason}); is it a tcp endpoint?"
    if shown.certificate is None:
        return "the orchestrator asks for a certificate: give --certificate and --key"
    why = reason.rpartition("ALERT_")[2].replace("_", " ").lower()
    return (
        f"the orchestrator refuses the certificate {shown.certificate} ({why}): "
        "expected one that is signed by its `attach.authority`"
    )


def _refused_user(shown: Credentials) -> str:
    if shown.user is None:
        return "the orchestrator breaks off: it asks for a user and a password; give --user and --password-file"
    return f"the orchestrator refuses the user '{shown.user}' or the password; its file `attach.users` has them"


def _check_couple(certificate_name: str, certificate: Path | None, key_name: str, key: Path | None) -> None:
    if (certificate is None) != (key is None):
        there, missing = (certificate_name, key_name) if certificate else (key_name, certificate_name)
        raise CredentialsError(f"{there} is given without {missing}: a certificate goes with its private key")
    if certificate is None or key is None:
        return
    _check_pem(certificate_name, certificate, "CERTIFICATE")
    _check_pem(key_name, key, "PRIVATE KEY")
    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, key)
    except ssl.SSLError as error:
        if "MISMATCH" not in (error.reason or ""):
            raise CredentialsError(
                f"{certificate_name}, {key_name}: cannot use {certificate} and {key}: {error}"
            ) from None
        raise CredentialsError(f"{key_name}: {key} is not the private key of the certificate {certificate}") from None


def _check_pem(name: str, path: Path, kind: str) -> None:
    text = _read(name, path)
    if f"{kind}-----" not in text:
        raise CredentialsError(f"{name}: {path} holds no '-----BEGIN {kind}-----', expected a PEM file with one")
    if "ENCRYPTED" in text:
        raise CredentialsError(f"{name}: {path} is protected by a passphrase, expected a key without one")
    if kind == "CERTIFICATE":
        try:
            ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT).load_verify_locations(path)
        except ssl.SSLError as error:
            raise CredentialsError(f"{name}: {path} holds a damaged certificate: {error.reason}") from None


def _read(name: str, path: Path) -> str:
    try:
        return path.read_text(errors="replace")
    except OSError as error:
        raise CredentialsError(f"{name}: cannot read {path}: {error.strerror}") from None
