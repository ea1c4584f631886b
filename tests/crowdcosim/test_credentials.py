"""Who gets in and who does not: an orchestrator's bus and a component's bus over TLS on the loopback interface."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
import trustme
from cryptography.hazmat.primitives import serialization

from crowdcosim.bus import Bus, BusError
from crowdcosim.credentials import Admission, Credentials, obstacle


@pytest.fixture(scope="module")
def papers(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """Certificates of two authorities, one of whom nobody knows, keys, and a list of users."""
    folder = tmp_path_factory.mktemp("papers")
    for name in ("ours", "others"):
        authority = trustme.CA()
        authority.cert_pem.write_to_path(str(folder / f"{name}.ca"))
        for whose, host in (("server", "127.0.0.1"), ("elsewhere", "robots.example"), ("client", "client.example")):
            certificate = authority.issue_cert(host)
            certificate.cert_chain_pems[0].write_to_path(str(folder / f"{name}.{whose}"))
            certificate.private_key_pem.write_to_path(str(folder / f"{name}.{whose}.key"))
    key = serialization.load_pem_private_key((folder / "ours.client.key").read_bytes(), None)
    locked = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.BestAvailableEncryption(b"passphrase"),
    )
    (folder / "locked.key").write_bytes(locked)
    (folder / "damaged").write_text("-----BEGIN CERTIFICATE-----\nMIIB\n-----END CERTIFICATE-----\n")
    (folder / "users").write_text("ann:apple\n\nbob:banana:split\n")
    (folder / "no-colon").write_text("ann:apple\nbob\n")
    (folder / "nobody").write_text("\n")
    return SimpleNamespace(folder=folder, path=lambda name: folder / name)


@pytest.fixture
def admission(papers: SimpleNamespace) -> Admission:
    """TLS, a certificate and a user are demanded."""
    return Admission(
        listen=f"tls/127.0.0.1:{free_port()}",
        certificate=papers.path("ours.server"),
        key=papers.path("ours.server.key"),
        authority=papers.path("ours.ca"),
        users=papers.path("users"),
    )


@pytest.fixture
def known(papers: SimpleNamespace) -> Credentials:
    """Who is let in."""
    return Credentials(
        authority=papers.path("ours.ca"),
        certificate=papers.path("ours.client"),
        key=papers.path("ours.client.key"),
        user="ann",
        password="apple",
    )


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def talk(one: Bus, other: Bus) -> None:
    """A message goes from one to the other."""
    mailbox = one.mailbox("run/**")
    one.announce("run/orchestrator/alive")
    assert other.presence("run/**/alive").wait() == ("run/orchestrator/alive", True)
    publisher = other.publisher("run/crowd/crowd")
    until = time.monotonic() + 10
    while (received := mailbox.poll()) is None and time.monotonic() < until:
        publisher.send(b"hello")
        time.sleep(0.01)
    assert received is not None
    assert received.payload == b"hello"


@pytest.fixture
def door(admission: Admission) -> Iterator[Bus]:
    bus = Bus.listen(admission=admission)
    yield bus
    bus.close()


def test_who_shows_a_certificate_and_a_user_is_let_in(door: Bus, admission: Admission, known: Credentials) -> None:
    outsider = Bus.connect(admission.listen, credentials=known)
    talk(door, outsider)
    outsider.close()


def test_a_password_may_have_a_colon(door: Bus, admission: Admission, known: Credentials) -> None:
    Bus.connect(admission.listen, credentials=replace(known, user="bob", password="banana:split")).close()


def test_this_machines_processes_come_in_at_the_loopback_with_a_user_of_their_own(
    door: Bus, admission: Admission, known: Credentials
) -> None:
    assert door.endpoint.startswith("tcp/127.0.0.1:")
    insider = Bus.connect(door.endpoint, credentials=Credentials(**door.identity))
    outsider = Bus.connect(admission.listen, credentials=known)
    talk(door, insider)
    talk(outsider, insider)
    for bus in (insider, outsider):
        bus.close()


def test_two_orchestrators_give_their_processes_different_passwords(door: Bus, admission: Admission) -> None:
    other = Bus.listen(admission=replace(admission, listen=f"tls/127.0.0.1:{free_port()}"))
    assert other.identity.keys() == door.identity.keys() == {"user", "password"}
    assert other.identity["password"] != door.identity["password"]
    other.close()


def test_the_file_from_which_zenoh_takes_the_passwords_is_gone_at_once(
    admission: Admission, known: Credentials, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    bus = Bus.listen(admission=admission)
    assert list(tmp_path.iterdir()) == []
    Bus.connect(admission.listen, credentials=known).close()
    bus.close()


def test_without_users_and_authority_nothing_is_asked(papers: SimpleNamespace, admission: Admission) -> None:
    bus = Bus.listen(admission=replace(admission, authority=None, users=None))
    assert bus.identity == {}
    outsider = Bus.connect(admission.listen, credentials=Credentials(authority=papers.path("ours.ca")))
    insider = Bus.connect(bus.endpoint)
    talk(outsider, insider)
    for each in (outsider, insider, bus):
        each.close()


REFUSED = {
    "another authority": ({"authority": "others.ca"}, ["the orchestrator's certificate is refused", "others.ca"]),
    "no authority": ({"authority": None}, ["the orchestrator's certificate is refused", "give --authority"]),
    "no certificate": (
        {"certificate": None, "key": None},
        ["asks for a certificate", "give --certificate and --key"],
    ),
    "another's certificate": (
        {"certificate": "others.client", "key": "others.client.key"},
        ["refuses the certificate", "others.client", "attach.authority"],
    ),
    "no user": ({"user": None, "password": None}, ["asks for a user and a password", "--password-file"]),
    "wrong user": ({"user": "eve"}, ["refuses the user 'eve' or the password"]),
    "wrong password": ({"password": "pear"}, ["refuses the user 'ann' or the password"]),
    "a key that does not fit": ({"key": "others.client.key"}, ["--key", "is not the private key of the certificate"]),
    "a key that is not there": ({"key": "gone.key"}, ["--key: cannot read", "gone.key: No such file"]),
    "a key that is none": ({"key": "users"}, ["--key", "expected a PEM file"]),
    "a locked key": ({"key": "locked.key"}, ["--key", "passphrase"]),
    "a damaged authority": ({"authority": "damaged"}, ["--authority", "damaged certificate"]),
    "a certificate without a key": ({"key": None}, ["--certificate is given without --key"]),
    "a user without a password": ({"password": None}, ["a user without a password"]),
}


@pytest.mark.parametrize(("change", "words"), REFUSED.values(), ids=REFUSED)
def test_a_component_that_is_refused_says_why_at_once(
    door: Bus, papers: SimpleNamespace, admission: Admission, known: Credentials, change: dict, words: list[str]
) -> None:
    paths = {k: papers.path(v) if v and k in ("authority", "certificate", "key") else v for k, v in change.items()}
    began = time.monotonic()
    with pytest.raises(BusError) as caught:
        Bus.connect(admission.listen, 30.0, credentials=replace(known, **paths))
    assert time.monotonic() - began < 15  # two looks of at most a second each, long before the deadline
    for word in words:
        assert word in str(caught.value)
    for secret in ("apple", "pear"):
        assert secret not in str(caught.value)


def test_a_password_is_asked_for_at_the_loopback_too(door: Bus) -> None:
    with pytest.raises(BusError, match="asks for a user and a password"):
        Bus.connect(door.endpoint)


def test_a_certificate_for_another_host_is_refused(
    papers: SimpleNamespace, admission: Admission, known: Credentials
) -> None:
    other = replace(admission, certificate=papers.path("ours.elsewhere"), key=papers.path("ours.elsewhere.key"))
    bus = Bus.listen(admission=other)
    with pytest.raises(BusError, match=r"certificate is refused: .*expected one for '127\.0\.0\.1'"):
        Bus.connect(admission.listen, credentials=known)
    bus.close()


def test_tls_where_none_is_spoken_is_named(known: Credentials) -> None:
    bus = Bus.listen()
    cause = obstacle(bus.endpoint.replace("tcp/", "tls/"), known)
    assert cause.lasting
    assert "no TLS is spoken there" in cause.text
    bus.close()


@pytest.mark.parametrize(
    ("endpoint", "words"),
    [
        ("tls/127.0.0.1:1", "nobody answers: Connection refused"),
        ("tls/no-such-host.invalid:7450", "there is no host 'no-such-host.invalid'"),
        ("7450", "expected an endpoint such as tls/"),
    ],
)
def test_where_nobody_listens_is_said_at_the_deadline(endpoint: str, words: str) -> None:
    with pytest.raises(BusError, match=words):
        Bus.connect(endpoint, 0.2)


UNUSABLE = {
    "no such certificate": ({"certificate": "gone"}, "attach.certificate: cannot read .*gone: No such file"),
    "another's key": ({"key": "others.server.key"}, "attach.key: .* is not the private key of the certificate"),
    "no certificate": ({"certificate": "users"}, "attach.certificate: .*expected a PEM file"),
    "a damaged authority": ({"authority": "damaged"}, "attach.authority: .*damaged certificate"),
    "no such users": ({"users": "gone"}, "attach.users: cannot read"),
    "a line without a colon": ({"users": "no-colon"}, "no-colon:2: expected a line `user:password`"),
    "a list of nobody": ({"users": "nobody"}, "has no user"),
}


@pytest.mark.parametrize(("change", "words"), UNUSABLE.values(), ids=UNUSABLE)
def test_an_orchestrator_with_unusable_papers_says_which(
    papers: SimpleNamespace, admission: Admission, change: dict[str, str], words: str
) -> None:
    with pytest.raises(BusError, match=words):
        Bus.listen(admission=replace(admission, **{key: papers.path(name) for key, name in change.items()}))


def test_a_port_that_is_taken_is_named(door: Bus, admission: Admission) -> None:
    with pytest.raises(BusError, match=f"cannot listen at .*{admission.listen}"):
        Bus.listen(admission=admission)
