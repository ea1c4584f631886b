"""The report of an episode: what is on the page, and what is not."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crowdcosim.messages import Contacts, Crowd, Metrics, RobotState
from crowdcosim.robots import Target
from crowdcosim.world import Wall, World
from orchestrator.episode import Metric
from orchestrator.errors import InputError
from orchestrator.log.reader import read_log
from orchestrator.log.recorder import Channel, Recorder, as_json, record
from orchestrator.report.data import read_episode, touches
from orchestrator.report.page import (
    EpisodeData,
    RobotTrack,
    Snapshot,
    Touch,
    hardest_touches,
    metric_lines,
    render_report,
    write_report,
)
from orchestrator.scenario.scenario import load

CORRIDOR = World(
    size=(50.0, 10.0),
    periodic=(True, True),
    walls=tuple(
        Wall(start=start, end=end, stops_people=False)
        for start, end in (((0, 0), (50, 0)), ((50, 0), (50, 10)), ((50, 10), (0, 10)), ((0, 10), (0, 0)))
    ),
)


def track(name: str = "robot", seed: int = 3, lane: float = 5.0) -> RobotTrack:
    """A robot that winds its way along the corridor, stops twice, and is touched meanwhile."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, 47.65, 0.1)
    slow = np.exp(-(((time - 18) / 1.5) ** 2)) + np.exp(-(((time - 33) / 2.5) ** 2)) + np.exp(-((time / 0.3) ** 2))
    speed = np.clip(1.0 - slow + 0.02 * rng.normal(size=time.size), -0.1, 1.0)
    heading = 0.35 * np.sin(0.5 * time) * np.exp(-(((time - 22) / 12) ** 2))
    step = 0.1 * speed[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    position = np.array([5.0, lane]) + np.cumsum(step, axis=0)
    touched = [
        Touch(
            kind=Contacts.PERSON,
            agent=agent,
            body_part=part,
            begin=begin,
            end=begin + length,
            position=(float(position[int(begin * 10), 0]), float(position[int(begin * 10), 1]) + 0.2),
            approach_speed=approach,
            energy=0.5 * 7.9 * approach**2,
        )
        for agent, part, begin, length, approach in (
            (12, Contacts.LOWER_LEGS, 17.2, 0.9, 1.9),
            (55, Contacts.FEET, 18.4, 0.2, 0.6),
            (71, Contacts.LOWER_LEGS, 32.0, 2.4, 1.2),
        )
    ]
    wall = replace(touched[0], kind=Contacts.WALL, begin=40.0, end=40.1, position=(35.0, 4.0))
    return RobotTrack(
        name=name,
        radius=0.177,
        goal=Target(x=45.0, y=5.0, direction=(1.0, 0.0)),
        time=time,
        position=position,
        heading=heading,
        speed=speed,
        angular_velocity=np.gradient(heading, time) + 0.03 * rng.normal(size=time.size),
        nearest=0.5 + 2.2 * np.abs(np.sin(0.31 * time)) + 0.15 * rng.random(time.size),
        touches=(*touched, wall),
        arrival=47.5,
    )


def metrics(robot: str = "robot") -> tuple[Metric, ...]:
    rows: list[tuple[str, float | None, str, str]] = [
        ("time_ratio", 0.764, "1", ""),
        ("path_length_ratio", 0.972, "1", ""),
        ("velocity_variation_ratio", None, "1", "the robot did not reach its goal"),
        ("neighbour_velocity", 0.871, "1", ""),
        ("colliding", 0.933, "1", ""),
        ("collision_rate", 0.0574, "1/s", ""),
        ("time", 52.3, "s", ""),
        ("my_own", 7.25, "m", ""),
    ]
    return tuple(Metric(robot=robot, name=n, value=v, unit=u, reason=r) for n, v, u, r in rows)


@pytest.fixture(scope="module")
def data() -> EpisodeData:
    rng = np.random.default_rng(1)
    return EpisodeData(
        scenario="corridor",
        description="A TurtleBot2 drives 40 m along a corridor through 100 people who walk against it.",
        seed="1",
        outcome="reached the goal",
        data_hash="3f" * 32,
        complete=True,
        versions={"crowdcosim": "0.1.0", "python": "3.11.9", "git_commit": "258b72e", "numpy": "2.4.6"},
        world=CORRIDOR,
        duration=47.6,
        robots=(track(),),
        snapshots=tuple(
            Snapshot(
                time=time,
                position=rng.uniform((0, 0), (50, 10), (100, 2)),
                heading=np.pi + 0.2 * rng.normal(size=100),
                radius=np.full(100, 0.3),
            )
            for time in (0.0, 15.9, 31.7, 47.6)
        ),
        metrics=metrics(),
    )


@pytest.fixture(scope="module")
def page(data: EpisodeData) -> str:
    return render_report(data)


class Elements(HTMLParser):
    """All start tags of a page with their attributes, and whether they close in order."""

    VOID = frozenset(("meta", "link", "br", "img", "input"))

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def text_of(page: str) -> str:
    """The page's words without markup, drawings and styles."""
    page = re.sub(r"<(style|svg)\b.*?</\1>", " ", page, flags=re.DOTALL)
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))


def test_the_page_says_what_ran_and_how_it_ended(data: EpisodeData, page: str) -> None:
    text = text_of(page)
    for words in ("corridor", data.description, "reached the goal", "47.6 s", "258b72e", data.data_hash, "0.1.0"):
        assert words in text


def test_each_metric_has_symbol_value_unit_and_what_is_better(page: str) -> None:
    text = text_of(page)
    assert "T/Tcr Time to the goal, alone over in the crowd. 0.764 higher" in text
    assert "f_c Collisions with people per time. 0.057 1/s lower" in text


def test_a_metric_without_a_value_gives_the_reason_instead(page: str) -> None:
    text = text_of(page)
    assert "J/Jcr Variation of velocity on the way to the goal, alone over in the crowd. the robot did not" in text


def test_a_metric_of_the_users_own_goes_by_its_name(page: str) -> None:
    assert "my_own 7.250 m" in text_of(page)


def test_the_page_needs_no_network(page: str) -> None:
    for tag, attributes in Elements(page).found:
        assert tag not in ("script", "link", "img", "iframe", "image")
        for name, value in attributes.items():
            if name in ("href", "src", "xlink:href"):
                assert value is not None
                assert value.startswith("#")
    assert "url(http" not in page
    assert "@import" not in page


def test_the_page_is_well_formed_and_every_reference_within_it_has_one_target(data: EpisodeData) -> None:
    page = render_report(replace(data, robots=(track(), track("second", seed=4, lane=3.0))))
    elements = Elements(page)
    assert elements.open == []
    ids = [attributes["id"] for _, attributes in elements.found if "id" in attributes]
    assert len(set(ids)) == len(ids)
    referred = set(re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', page))
    assert {a or b for a, b in referred} <= set(ids)


def test_equal_data_give_equal_pages(data: EpisodeData, page: str) -> None:
    assert render_report(data) == page


def test_colours_come_from_the_page_so_that_dark_mode_works(page: str) -> None:
    assert "#0101" not in page
    used = set(re.findall(r"var\(--([a-z]+)\)", page))
    assert used <= set(re.findall(r"--([a-z]+):", page))


def test_text_from_the_user_is_escaped(data: EpisodeData) -> None:
    evil = "<script>alert(1)</script>&"
    changed = replace(
        data,
        scenario=evil,
        description=evil,
        robots=(track(evil), track("b$_{x}$")),
        outcome=f"failed: {evil}",
        metrics=tuple(replace(m, robot=evil, name=evil) for m in data.metrics[:1]),
    )
    page = render_report(changed)
    assert "<script" not in page
    assert page.count("&lt;script&gt;alert(1)&lt;/script&gt;&amp;") >= 6
    assert "b$_{x}$" in page  # not taken for a formula


def test_a_log_that_was_cut_off_is_called_so(data: EpisodeData, page: str) -> None:
    assert "cut off" not in text_of(page)
    assert "The log was cut off" in text_of(render_report(replace(data, complete=False, metrics=())))


def test_an_episode_with_nobody_in_it_still_has_a_page(data: EpisodeData) -> None:
    lonely = replace(track(), nearest=np.full(477, np.inf), touches=(), arrival=None)
    page = render_report(replace(data, robots=(lonely,), snapshots=(), metrics=()))
    assert "nobody" in page
    assert "Metrics" not in text_of(page)
    assert Elements(render_report(replace(data, robots=(), snapshots=(), metrics=()))).open == []


def test_a_robot_whose_first_step_failed_still_has_a_page(data: EpisodeData) -> None:
    one, none = (
        replace(
            track(),
            **{name: getattr(track(), name)[:n] for name in ("time", "position", "heading", "speed", "nearest")},
            angular_velocity=np.zeros(n),
            touches=(),
            arrival=None,
        )
        for n in (1, 0)
    )
    assert Elements(render_report(replace(data, robots=(one, none)))).open == []


@pytest.mark.parametrize("size", [(50.0, 10.0), (20.0, 20.0), (8.0, 40.0)])
def test_every_instant_is_drawn_in_a_world_of_any_shape(data: EpisodeData, size: tuple[float, float]) -> None:
    page = render_report(replace(data, world=World(size=size)))
    for instant in data.snapshots:
        assert f">{instant.time:.1f} s<" in page


def test_a_path_across_the_seam_is_not_drawn_across_the_world(data: EpisodeData) -> None:
    from orchestrator.report.figures import _pieces, _speed_norm

    position = np.column_stack([np.arange(45.0, 55.0, 0.5) % 50, np.full(20, 5.0)])
    pieces = [p for p, _ in _pieces(position, np.ones(20), CORRIDOR, _speed_norm(data))]
    assert [(p[0, 0], p[-1, 0]) for p in pieces] == [(45.0, 49.5), (0.0, 4.5)]


def test_a_path_is_cut_where_the_speed_changes_its_level_and_stays_whole_otherwise(data: EpisodeData) -> None:
    from orchestrator.report.figures import _pieces, _speed_norm

    position = np.column_stack([np.arange(20.0), np.full(20, 5.0)])
    speed = np.where(np.arange(20) < 10, 0.15, 0.95)
    pieces = [p for p, _ in _pieces(position, speed, CORRIDOR, _speed_norm(data))]
    assert [(p[0, 0], p[-1, 0]) for p in pieces] == [(0.0, 9.0), (9.0, 10.0), (10.0, 19.0)]


def test_one_table_holds_all_robots_and_a_gap_where_one_lacks_a_metric() -> None:
    lines = metric_lines((*metrics("a"), *metrics("b")[:-1]))
    assert [line.symbol for line in lines][:2] == ["T/Tcr", "L/Lcr"]
    own = next(line for line in lines if line.symbol == "my_own")
    assert own.values[0] is not None
    assert own.values[1] is None


def test_contacts_are_listed_hardest_first_without_walls(data: EpisodeData) -> None:
    assert [touch.agent for _, touch in hardest_touches(data)] == [12, 71, 55]


def report(agent: list[int], duration: list[float], **fields: Any) -> Contacts:
    n = len(agent)
    values: dict[str, Any] = {
        "kind": [Contacts.PERSON] * n,
        "body_part": [Contacts.FEET] * n,
        "robot_part": [Contacts.FRONT] * n,
        "striker": [Contacts.BY_BOTH] * n,
        "position": np.zeros((n, 2)),
        "normal": np.zeros((n, 2)),
        "relative_velocity": np.zeros((n, 2)),
        "approach_speed": np.zeros(n),
        "robot_closing_speed": np.zeros(n),
        "reflected_mass": np.zeros(n),
        "energy": np.zeros(n),
    }
    return Contacts(robot="robot", agent=np.array(agent), duration=np.array(duration), **(values | fields))


def test_a_contact_lasts_from_its_first_step_to_its_last() -> None:
    reports = [
        (0.1, report([], [])),
        (0.2, report([7], [0.0])),
        (0.3, report([7, 9], [0.1, 0.0])),
        (0.4, report([7], [0.2])),
        (0.9, report([7], [0.0])),
    ]
    found = [(t.agent, t.begin, t.end) for t in touches(reports, 0.1)]
    assert found == [
        (7, pytest.approx(0.1), 0.4),
        (9, pytest.approx(0.2), 0.3),
        (7, pytest.approx(0.8), 0.9),
    ]


def test_a_person_and_a_wall_of_the_same_number_are_two_contacts() -> None:
    both = report([1, 1], [0.0, 0.0], kind=[Contacts.PERSON, Contacts.WALL])
    assert len(touches([(0.1, both)], 0.1)) == 2


def test_the_page_stays_small(data: EpisodeData) -> None:
    crowded = tuple(
        replace(s, position=np.tile(s.position, (4, 1)), heading=np.tile(s.heading, 4), radius=np.tile(s.radius, 4))
        for s in data.snapshots
    )
    assert len(render_report(replace(data, snapshots=crowded))) < 1_000_000  # bytes, with 400 people


CHANNELS = tuple(
    Channel(topic, kind.TYPE, *place)
    for topic, kind, place in (
        ("/crowd", Crowd, ("crowd", "crowd")),
        ("/robot/state", RobotState, ("robot", "state")),
        ("/robot/contacts", Contacts, ("robot", "contacts")),
        ("/evaluator/metrics", Metrics, ("evaluator", "metrics")),
    )
)


@pytest.fixture
def log(folder: Path) -> Path:
    """Three states of a robot that drives at 10 m/s past its goal at x = 45, 3 m from the one person there is."""
    path = folder / "episode.mcap"
    attachments = {"scenario.json": as_json(load("base.yaml").resolved)}
    recorder = Recorder(path, CHANNELS, attachments=attachments, metadata={"run": {"seed": "1", "numpy": "2.4.6"}})
    for k in range(3):
        x, time = 43.5 + k, k * 100_000_000
        names = ("heading", "radius", "stature", "mass", "gait_phase", "gait_speed")
        person: dict[str, Any] = {name: [0.0] for name in names}
        crowd = Crowd(id=[1], group=[0], position=[[x, 8.0]], velocity=[[0.0, 0.0]], **person)
        robot = RobotState(name="robot", position=[x, 5.0], heading=np.pi, velocity=[10.0, 0.0])
        contacts = report([1], [0.0]) if k == 2 else report([], [])
        recorder.add(
            [
                record("/crowd", time, crowd),
                record("/robot/state", time, robot),
                record("/robot/contacts", time, contacts),
            ]
        )
    verdict = Metrics(robot=("robot",), name=("time",), unit=("s",), value=[0.2], valid=[True], reason=("",))
    recorder.add([record("/evaluator/metrics", 200_000_000, verdict)])
    recorder.close({"outcome": {"reason": "goal", "ticks": "2"}})
    return path


def test_an_episode_is_read_from_its_log(log: Path) -> None:
    episode = read_episode(read_log(log))
    assert (episode.scenario, episode.seed, episode.outcome) == ("base", "1", "reached the goal")
    assert (episode.complete, episode.duration, dict(episode.versions)) == (True, 0.2, {"numpy": "2.4.6"})
    assert [m.name for m in episode.metrics] == ["time"]
    assert [s.time for s in episode.snapshots] == [0.0, 0.1, 0.2]
    (robot,) = episode.robots
    assert robot.time.tolist() == [0.0, 0.1, 0.2]
    assert robot.speed == pytest.approx(-10.0)  # it drives backward
    assert robot.nearest == pytest.approx(3.0)
    assert robot.arrival == 0.2
    assert [(t.begin, t.end) for t in robot.touches] == [(pytest.approx(0.1), 0.2)]


def test_a_report_is_one_file_beside_the_log(log: Path, folder: Path) -> None:
    write_report(log, folder / "report.html")
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "T Time to the goal. 0.200 s lower" in text_of(page)
    assert read_log(log).data_hash() in page


def test_a_log_of_something_else_is_refused(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "other.mcap", CHANNELS, attachments={}, metadata={})
    recorder.close({})
    with pytest.raises(InputError, match=r"no attachment 'scenario\.json'"):
        write_report(tmp_path / "other.mcap", tmp_path / "report.html")
