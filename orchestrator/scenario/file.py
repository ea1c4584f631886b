"""What may stand in a scenario file: one dataclass per mapping, from which the checks and the JSON Schema are made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, TypeAdapter

from crowdcosim.mesh import Mesh
from crowdcosim.obstacles import Obstacle
from crowdcosim.robots import Pose, RobotModel, Target
from crowdcosim.world import Wall, World
from orchestrator.pictures.cameras import Camera

_NAME = r"^[A-Za-z][A-Za-z0-9_-]*$"
_RUN_NAME = r"^[A-Za-z0-9][A-Za-z0-9._+-]*$"
_PORT_NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"
_PORT = r"^[A-Za-z][A-Za-z0-9_/-]*(\.[A-Za-z_][A-Za-z0-9_]*)?$"
FORMS = {
    _NAME: "a name of letters, digits, _ and -, beginning with a letter",
    _RUN_NAME: "a name of letters, digits, and . _ + -, beginning with a letter or digit",
    _PORT_NAME: "a port's name",
    _PORT: "component.port or component, such as robot/lidar.scan",
}
"""what the patterns of this file mean"""

Name = Annotated[str, Field(pattern=_NAME)]
RunName = Annotated[str, Field(pattern=_RUN_NAME)]
PortName = Annotated[str, Field(pattern=_PORT_NAME)]
PortReference = Annotated[str, Field(pattern=_PORT)]
Positive = Annotated[float, Field(gt=0)]

_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)

NOT_ROBOTS = ("crowd", "evaluator", "orchestrator", "tick")
"""names that no robot may have: they are other components or topics of a run"""
NOT_SENSORS = ("command", "controller", "goal")
"""names that no sensor may have: they are other components of its robot"""


@dataclass(frozen=True, kw_only=True)
class ComponentEntry:
    """One component: what it is (`use` or `exec`), where it runs, how often, and its options."""

    __pydantic_config__ = _STRICT

    use: str | None = None
    """a shipped component's short name, `package.module:Class`, or `./file.py:Class` relative to this file"""
    exec: Annotated[tuple[str, ...], Field(min_length=1)] | None = None
    """instead of `use`: the command line of a component in any language"""
    cwd: str | None = None
    """folder in which `exec` runs; this file's folder if left out"""
    host: Literal["process", "inline", "external"] | None = None
    """a process of its own, within the orchestrator, or started by someone else; the scenario's `host` if left out"""
    every: Annotated[int, Field(ge=1)] = 1
    """steps once in so many ticks and holds its last output between"""
    config: Mapping[str, Any] = field(default_factory=dict)
    """the component's options"""
    inputs: Mapping[PortName, PortReference] = field(default_factory=dict)
    """input port -> `component.port` or `component`, where the types leave a choice"""


@dataclass(frozen=True, kw_only=True)
class SensorEntry(ComponentEntry):
    """A robot's sensor: a component, or a device by name."""

    __pydantic_config__ = _STRICT

    preset: str | None = None
    """a shipped device's name, or `./file.yaml`: component and options, of which this entry changes what it says"""


@dataclass(frozen=True, kw_only=True)
class ControllerEntry(ComponentEntry):
    """A robot's controller: a component, and how long after sensing its commands take effect."""

    __pydantic_config__ = _STRICT

    latency: Annotated[float, Field(ge=0)] | Literal["measured"] = 0.0
    """a command takes effect so long after its tick [s], or after the computing time as `measured`: not repeatable"""


@dataclass(frozen=True, kw_only=True)
class RobotEntry:
    """One robot: its body, task and components."""

    model: RobotModel
    """a shipped robot's name, `./file.yaml`, or the fields of a robot; with `extends`, changes to another"""
    start: Pose
    goal: Target
    drive: ComponentEntry
    """turns commands into motion"""
    sensors: Mapping[Name, SensorEntry] = field(default_factory=dict)
    """sensor's name -> component"""
    controller: ControllerEntry | None = None
    """turns observations into commands"""


@dataclass(frozen=True, kw_only=True)
class WorldEntry:
    """The ground plane: a rectangle from (0, 0) to `size`."""

    size: tuple[Positive, Positive]
    """extent in x and y [m]"""
    periodic: tuple[bool, bool] = World.periodic
    """axes along which people who leave re-enter at the opposite side"""
    boundary: Literal["none", "robots", "all"] = "none"
    """walls along the four edges that stop nobody, robots only, or people too (not along the periodic axes)"""
    walls: tuple[Wall, ...] = ()
    """further walls"""
    obstacles: tuple[Obstacle, ...] = ()
    """boxes, discs and polygons that nothing goes through"""
    mesh: Mesh | None = None
    """a mesh file, seen by LiDARs and cameras; people and robots go through it"""
    ceiling: Positive | None = None
    """height of a ceiling over everything, with lamps, seen by cameras; none: the open sky [m]"""


@dataclass(frozen=True, kw_only=True)
class Ending:
    """When an episode ends."""

    time_limit: Positive
    """[s]"""
    goal: Literal["all", "any", "none"] = "all"
    """ends when all robots, or any of them, have reached their goals; or runs to the time limit"""
    collision: bool = False
    """ends at the first contact of a robot with a person"""


@dataclass(frozen=True, kw_only=True)
class Deadlines:
    """How long a component may be silent before the run fails, in wall-clock time."""

    start: Positive = 60.0
    """from its start to the end of its reset [s]; the first compile takes its time"""
    step: Positive = 10.0
    """per tick [s]"""


@dataclass(frozen=True, kw_only=True)
class AttachEntry:
    """Where `external` components come in from other machines, and whom the orchestrator lets in. Paths are relative to
    the file that says so. The log carries none of it."""

    listen: str
    """endpoint, such as tls/0.0.0.0:7450 or, unprotected, tcp/0.0.0.0:7450"""
    certificate: str | None = None
    """the orchestrator's certificate (PEM), for TLS"""
    key: str | None = None
    """the private key of `certificate` (PEM, without a passphrase)"""
    authority: str | None = None
    """if given, components must show a certificate that was signed by one of these (PEM)"""
    users: str | None = None
    """if given, components must show one of these: a file of lines `user:password`"""


@dataclass(frozen=True, kw_only=True)
class ScenarioFile:
    """A crowdcosim scenario."""

    __pydantic_config__ = _STRICT

    name: RunName
    """of the run; the file's own name if left out"""
    description: str = ""
    """one sentence for `crowdcosim list`"""
    seed: Annotated[int, Field(ge=0, lt=2**64)] = 1
    """every component draws its randomness from this and its own name"""
    dt: Positive
    """time step, whole nanoseconds [s]"""
    world: WorldEntry
    host: Literal["process", "inline"] = "process"
    """where components run that do not say it themselves"""
    crowd: ComponentEntry | None = None
    """the people; nobody if left out"""
    robots: Mapping[Name, RobotEntry] = field(default_factory=dict)
    """robot's name -> robot"""
    evaluator: ComponentEntry | None = None
    """judges the run; nobody does if left out"""
    reference: bool = True
    """before the run, the robots do it without people: the ratios of the metrics compare with that"""
    end: Ending
    deadlines: Deadlines = field(default_factory=Deadlines)
    attach: AttachEntry | None = None
    """for components on other machines; if left out, the orchestrator listens on the loopback interface only"""
    cameras: Mapping[Name, Camera] = field(default_factory=dict)
    """camera's name -> what `crowdcosim render` looks through"""


@cache
def adapter() -> TypeAdapter[ScenarioFile]:
    """Validator of a whole scenario; what it contains inherits that unknown keys are refused."""
    return TypeAdapter(ScenarioFile)


@cache
def component_adapter() -> TypeAdapter[ComponentEntry]:
    return TypeAdapter(ComponentEntry)


@cache
def sensor_adapter() -> TypeAdapter[SensorEntry]:
    return TypeAdapter(SensorEntry)


@cache
def controller_adapter() -> TypeAdapter[ControllerEntry]:
    return TypeAdapter(ControllerEntry)
