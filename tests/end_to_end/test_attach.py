"""Components on other machines attach over TLS with a certificate and a user, and nobody else does."""

from __future__ import annotations

import re
import shutil
import socket
import subprocess
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest
import trustme

BASELINE = "components.controllers.baseline:Baseline"
PASSWORD = "correct-horse"
SHORT = "end: {time_limit: 2}\nreference: false"
ADDRESSES = ("10.77.0.1", "10.77.0.2")
"""of the orchestrator's machine and of the other one, in namespaces where nobody else is"""


@pytest.fixture
def papers(tmp_path: Path) -> Path:
    """A folder with certificates of an authority, the orchestrator and a component, users, and a false authority."""
    folder = tmp_path / "papers"
    folder.mkdir()
    authority = trustme.CA()
    authority.cert_pem.write_to_path(str(folder / "ca.pem"))
    trustme.CA().cert_pem.write_to_path(str(folder / "other-ca.pem"))
    for name, hosts in (("server", ("127.0.0.1", ADDRESSES[0])), ("robot", ("robot.example",))):
        certificate = authority.issue_cert(*hosts)
        certificate.cert_chain_pems[0].write_to_path(str(folder / f"{name}.pem"))
        certificate.private_key_pem.write_to_path(str(folder / f"{name}.key"))
    (folder / "users.txt").write_text(f"robot:{PASSWORD}\n")
    (folder / "password.txt").write_text(f"{PASSWORD}\n")
    return folder


def attach(listen: str) -> str:
    """A scenario whose controller comes from outside."""
    return f"""
robots: {{robot: {{controller: {{host: external}}}}}}
{SHORT}
attach:
  listen: {listen}
  certificate: ./papers/server.pem
  key: ./papers/server.key
  authority: ./papers/ca.pem
  users: ./papers/users.txt
"""


def node(endpoint: str, *changes: str) -> list[str]:
    """What the other machine types; later options replace earlier ones."""
    address = ["--endpoint", endpoint, "--run", "small", "--component", "robot/controller"]
    certificates = ["--authority", "papers/ca.pem", "--certificate", "papers/robot.pem", "--key", "papers/robot.key"]
    return [BASELINE, *address, *certificates, "--user", "robot", "--password-file", "papers/password.txt", *changes]


def free_endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tls/127.0.0.1:{probe.getsockname()[1]}"


def finished(process: subprocess.Popen[str], timeout: float = 60.0) -> tuple[int, str, str]:
    stdout, stderr = process.communicate(timeout=timeout)
    return process.returncode, stdout, stderr


def test_a_controller_that_attaches_over_tls_gives_the_same_bytes(crowdcosim, scenario, papers) -> None:
    endpoint = free_endpoint()
    alone = crowdcosim("run", scenario(SHORT), "--host", "inline", "--out", "alone", "--json")
    path = scenario(attach(endpoint))
    with (
        crowdcosim.start("run", path, "--out", "out", "--json") as run,
        crowdcosim.start(*node(endpoint), module="crowdcosim.node") as outsider,
    ):
        code, stdout, stderr = finished(run)
        assert code == 0, stderr + finished(outsider)[2]
        assert finished(outsider) == (0, "", "")
    assert alone.code == 0, alone.stderr
    hashes = [re.search(r'"data_hash": "(\w+)"', text) for text in (alone.stdout, stdout)]
    assert hashes[0] is not None
    assert hashes[1] is not None
    assert hashes[0][1] == hashes[1][1]
    said = " ".join(stderr.split())  # lines are broken at the width of the terminal
    assert f"--endpoint {endpoint} --run small --component robot/controller" in said
    assert "with a certificate signed by ca.pem and a user of users.txt" in said
    told = stdout + stderr + (crowdcosim.folder / "out" / "result.json").read_text()
    assert PASSWORD not in told
    assert "server.key" not in told


def test_command_lines_of_the_orchestrators_own_get_in_while_users_are_asked_for(crowdcosim, scenario, papers) -> None:
    """Also one in another language, which learns user and password from its environment."""
    example = Path(__file__).parents[2] / "examples" / "plain_controller.py"
    text = attach(free_endpoint()).replace("host: external", f"exec: [python, {example}]")
    outcome = crowdcosim("run", scenario(text), "--out", "out")
    assert outcome.code == 0, outcome.stderr


@pytest.mark.slow
def test_who_is_refused_and_who_waited_in_vain_both_say_why(crowdcosim, scenario, papers) -> None:
    endpoint = free_endpoint()
    path = scenario(attach(endpoint) + "deadlines: {start: 6}\n")
    with (
        crowdcosim.start("run", path, "--out", "out") as run,
        crowdcosim.start(*node(endpoint, "--user", "eve"), module="crowdcosim.node") as outsider,
    ):
        code, _, stderr = finished(outsider)
        assert code == 2
        assert stderr.strip() == (
            f"error: cannot connect to {endpoint}: the orchestrator refuses the user 'eve' or the password; "
            "its file `attach.users` has them"
        )
        code, _, stderr = finished(run)
    assert code == 1
    assert "component 'robot/controller': has not attached within 6 s" in stderr
    assert "a certificate signed by ca.pem and a user of users.txt" in " ".join(stderr.split())
    assert "Traceback" not in stderr


def test_an_orchestrator_whose_key_does_not_fit_does_not_begin(crowdcosim, scenario, papers) -> None:
    path = scenario(attach(free_endpoint()).replace("server.key", "robot.key"))
    outcome = crowdcosim("run", path, "--out", "out")
    assert outcome.code == 2
    assert "attach.key: " in outcome.stderr
    assert "is not the private key of the certificate" in outcome.stderr


# --- two machines ------------------------------------------------------------------------------------------------


def ip(*arguments: str) -> None:
    subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True, timeout=10)


@pytest.fixture
def machines() -> Iterator[tuple[list[str], list[str]]]:
    """Two network namespaces with a cable between them; what runs a command in the one and in the other."""
    if shutil.which("ip") is None:
        pytest.skip("network namespaces need the program `ip` of iproute2")
    mark = uuid.uuid4().hex[:8]
    names = [f"crowdcosim-{mark}-{end}" for end in "ab"]
    cables = [f"cc{mark}{end}" for end in "ab"]
    try:
        try:
            for name in names:
                ip("netns", "add", name)
            ip("link", "add", cables[0], "netns", names[0], "type", "veth", "peer", cables[1], "netns", names[1])
        except subprocess.CalledProcessError as error:
            pytest.skip(f"network namespaces are not allowed here: {error.stderr.strip()}")
        for name, cable, address in zip(names, cables, ADDRESSES, strict=True):
            ip("-n", name, "address", "add", f"{address}/24", "dev", cable)
            ip("-n", name, "link", "set", cable, "up")
            ip("-n", name, "link", "set", "lo", "up")
        first, second = (["ip", "netns", "exec", name] for name in names)
        yield first, second
    finally:
        for name in names:
            subprocess.run(["ip", "netns", "delete", name], capture_output=True, timeout=10, check=False)


def listeners(within: list[str]) -> set[str]:
    """Addresses at which somebody listens in a namespace, as the kernel writes them."""
    table = subprocess.run(
        [*within, "cat", "/proc/net/tcp", "/proc/net/tcp6"], capture_output=True, text=True, check=True
    )
    rows = [line.split() for line in table.stdout.splitlines()]
    return {row[1].partition(":")[0] for row in rows if len(row) > 3 and row[3] == "0A"}


@pytest.mark.slow
def test_a_controller_on_another_machine_drives_and_one_with_a_wrong_key_is_refused(
    crowdcosim, scenario, papers, machines
) -> None:
    here, there = machines
    endpoint = f"tls/{ADDRESSES[0]}:7450"
    path = scenario(attach("tls/0.0.0.0:7450"))
    with crowdcosim.start("run", path, "--out", "out", "--json", within=here) as run:
        for change, words in (
            (("--authority", "papers/other-ca.pem"), "the orchestrator's certificate is refused"),
            (("--key", "papers/server.key"), "is not the private key of the certificate papers/robot.pem"),
            (("--password-file", "papers/users.txt"), "refuses the user 'robot' or the password"),
        ):
            with crowdcosim.start(*node(endpoint, *change), module="crowdcosim.node", within=there) as outsider:
                code, _, stderr = finished(outsider)
            assert code == 2
            assert words in stderr
            assert run.poll() is None
        with crowdcosim.start(*node(endpoint), module="crowdcosim.node", within=there) as outsider:
            code, stdout, stderr = finished(run)
            assert code == 0, stderr + finished(outsider)[2]
            assert finished(outsider) == (0, "", "")
    assert '"outcome": "time_limit"' in stdout
    assert f"--endpoint tls/{socket.gethostname()}:7450" in " ".join(stderr.split())


def test_without_attach_nobody_can_come_in_from_another_machine(crowdcosim, scenario, machines) -> None:
    here, _ = machines
    text = "robots: {robot: {controller: {host: external}}}\ndeadlines: {start: 4}\n"
    with crowdcosim.start("run", scenario(text), "--out", "out", within=here) as run:
        seen: set[str] = set()
        while run.poll() is None:
            seen |= listeners(here)
            time.sleep(0.2)
        _, _, stderr = finished(run)
    assert seen == {"0100007F"}  # 127.0.0.1
    assert "components on other machines need the scenario's `attach`" in stderr
