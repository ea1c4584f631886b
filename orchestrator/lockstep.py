"""The lockstep: one tick after the other, each from the committed state of the one before.

    1. sense     sensors read the state k and publish their observations of k
    2. decide    controllers read those and publish the commands of k
    3. move      crowd and robots step in parallel from the same old state k to k + 1
    4. commit    everything that was made in tick k is recorded, in one fixed order
    5. judge     evaluators observe; nothing flows back from them

Data travel from component to component; the lockstep only says which tick it is, steps the inline components, and
waits for everybody's answer.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from crowdcosim.bus import Label
from crowdcosim.cdr import decode, encode
from crowdcosim.host import FOREVER, ComponentHost, Source, blame
from crowdcosim.message import Message, MessageError, check_finite
from crowdcosim.messages import Tick
from orchestrator.errors import RunError
from orchestrator.remote import Data, Finished, Remote
from orchestrator.wiring import Graph


class Committed(NamedTuple):
    """One message as the log takes it."""

    component: str
    port: str
    time: int
    """simulated time of what the message holds [ns]"""
    payload: bytes
    """CDR"""


class _Held:
    """The latest message of one output, as bytes, as an object, or both."""

    __slots__ = ("label", "message", "payload", "type")

    def __init__(self, label: Label, typename: str, payload: bytes | None, message: Message | None) -> None:
        self.label = label
        self.type = typename
        self.payload = payload
        self.message = message

    def decoded(self) -> Message:
        if self.message is None:
            assert self.payload is not None
            self.message = decode(self.payload, self.type)
        return self.message

    def encoded(self) -> bytes:
        if self.payload is None:
            assert self.message is not None
            self.payload = encode(self.message)
        return self.payload


class Lockstep:
    """Steps all components of a graph, wherever they live."""

    def __init__(
        self,
        graph: Graph,
        *,
        period: int,
        constants: Mapping[tuple[str, str], Message],
        inline: Mapping[str, ComponentHost],
        remote: Remote | None,
        trusted: frozenset[str],
        commanded: frozenset[str] = frozenset(),
    ) -> None:
        """`commanded`: components that have nothing to say before `complete`, by name."""
        self._graph = graph
        self._period = period
        self._constants = constants
        self._inline = inline
        self._remote = remote
        self.commit: Callable[[list[Committed]], None] | None = None
        """takes what each tick has made, for the log"""
        self._steppers = tuple(n for n in graph.order if graph.members[n].every != FOREVER)
        self._remote_names = frozenset(remote.components if remote else ())
        late = graph.after(commanded)
        self._early = tuple(n for n in self._steppers if n in inline and n not in late)
        self._late = tuple(n for n in self._steppers if n in inline and n in late)
        self._types = {(n, o.name): o.type.TYPE for n, m in graph.members.items() for o in m.ports.outputs}
        self._order = {place: i for i, place in enumerate(self._types)}
        self._slow_movers = [p for p in self._types if self._is_slow_mover(p[0])]
        self._unchecked = [p for p in self._types if p[0] in self._remote_names and p[0] not in trusted]
        self._publishers = self._publishers_of_inline_outputs()
        # What is committed, and what this tick makes: readers of a state must not see the next one.
        # A mover that steps every n ticks is seen as it was until its step is over, so the one before is kept too.
        self._held: dict[tuple[str, str], _Held] = {}
        self._before: dict[tuple[str, str], _Held] = {}
        self._incoming: dict[tuple[str, str], _Held] = {}
        # Components elsewhere that have still to answer, with the number of outputs that are their answer (0: `done`).
        self._pending: dict[str, int] = {}
        self._episode = 0
        self.first_step: float | None = None
        """`time.monotonic()` at the first step of the first episode"""
        self.elapsed: dict[str, list[int]] = {name: [] for name in self._steppers}
        """wall-clock time of each component's own work per step [ns]"""
        self.thought: dict[str, int] = {}
        """time that who commands an inline component has taken for its next step, counted as its own [ns]"""

    # --- episode -------------------------------------------------------------------------------------------------

    def reset(self, *, alone: bool, reference: Mapping[str, Mapping[str, float]] | None) -> None:
        """Begin an episode: afterwards every mover's state at t = 0 is committed."""
        self._episode += 1
        self._held.clear()
        self._before.clear()
        self._incoming.clear()
        for times in self.elapsed.values():
            times.clear()
        setup: dict[str, Any] = {"alone": alone, "reference": reference}
        self._tell(Tick(phase=Tick.RESET, setup=json.dumps(setup)), self._steppers)
        for (component, port), message in self._constants.items():
            self._publish(component, port, Label(self._episode, 0, 0), message)
        for name in self._steppers:
            if host := self._inline.get(name):
                for port, message in self._guard(name, None, host.reset, **setup).items():
                    self._publish(name, port, Label(self._episode, 0, 0), message)
        self._await_answers(Tick.RESET, 0)
        self._require(self._having("mover"), None)
        self._commit(None)

    def step(self, tick: int) -> None:
        """Tick `tick`: from the committed state `tick` to the next."""
        self.observe(tick)
        self.complete(tick)

    def observe(self, tick: int) -> None:
        """The first part of a tick: everybody begins, and those step here whose say does not depend on a command."""
        self.first_step = self.first_step or time.monotonic()
        self._tell(Tick(phase=Tick.STEP, tick=tick, time=tick * self._period), self._due(self._steppers, tick))
        for name in self._due(self._early, tick):
            self._step_inline(name, self._inline[name], tick)

    def complete(self, tick: int) -> None:
        """The second part: the commanded components and all who wait for them; then everything is committed."""
        if self._remote:
            self._remote.resume()
        for name in self._due(self._late, tick):
            self._step_inline(name, self._inline[name], tick)
        self._await_answers(Tick.STEP, tick)
        self._commit(tick)

    def observe_end(self, tick: int) -> None:
        """A look at the final state `tick`, after `finish`: inline sensors step once more, and nothing is committed."""
        elsewhere = {n for n in self._remote_names if self._graph.members[n].ports.kind == "reactor"}
        blind = self._graph.after(elsewhere)
        for name in self._due(self._early, tick):
            if name not in blind:
                self._step_inline(name, self._inline[name], tick)

    def observed(self, component: str, port: str, tick: int) -> Any:
        """What an output says at `tick`, also if made in this tick, waiting for it if need be; None if nothing yet."""
        member = self._graph.members[component]
        source = Source(component=component, port=port, every=member.every, mover=member.ports.kind == "mover")
        place = (component, port)
        if component in self._pending and place not in self._incoming:
            self._reader(tick)(source, source.label(tick))
        held = self._incoming.get(place)
        return held.decoded() if held and held.label.tick <= tick else self.latest(component, port, tick)

    def finish(self, tick: int) -> None:
        """The last look: observers see the final state `tick` and give their verdict."""
        observers = self._having("observer")
        self._tell(Tick(phase=Tick.FINISH, tick=tick, time=tick * self._period), observers)
        label = Label(self._episode, tick, tick * self._period)
        for name in observers:
            if host := self._inline.get(name):
                for port, message in self._guard(name, tick, host.finish, tick, self._reader(tick)).items():
                    self._publish(name, port, label, message)
        self._await_answers(Tick.FINISH, tick)
        self._require(observers, tick)
        self._commit(tick)

    def newest(self, component: str, port: str) -> Any:
        """The message of an output that was committed last."""
        return self._held[component, port].decoded()

    def computing_time(self, component: str, port: str) -> int:
        """Wall-clock time that a component took for an output of this tick [ns]."""
        return self._incoming[component, port].label.elapsed

    def latest(self, component: str, port: str, tick: int) -> Any:
        """The committed message of an output that holds at `tick`; None if there is none."""
        for held in (self._held.get((component, port)), self._before.get((component, port))):
            if held is not None and held.label.tick <= tick:
                return held.decoded()
        return None

    # --- one tick ------------------------------------------------------------------------------------------------

    def _tell(self, tick: Tick, who: tuple[str, ...]) -> None:
        self._pending = {n: self._answers(n, tick.phase) for n in who if n in self._remote_names}
        if self._remote and (self._pending or tick.phase == Tick.STEP):
            message = Tick(
                phase=tick.phase,
                episode=self._episode,
                tick=tick.tick,
                period=self._period,
                time=tick.time,
                setup=tick.setup,
            )
            self._remote.tell(message, tuple(n for n in who if n in self._remote_names))

    def _due(self, names: tuple[str, ...], tick: int) -> tuple[str, ...]:
        return tuple([n for n in names if tick % self._graph.members[n].every == 0])

    def _step_inline(self, name: str, host: ComponentHost, tick: int) -> None:
        begin = time.perf_counter_ns()
        outputs = self._guard(name, tick, host.step, tick, self._reader(tick))
        elapsed = time.perf_counter_ns() - begin + self.thought.pop(name, 0)
        self.elapsed[name].append(elapsed)
        label = host.output_label(tick)
        for port, message in outputs.items():
            self._publish(name, port, Label(self._episode, label, label * self._period, elapsed), message)

    def _reader(self, tick: int) -> Callable[[Source, int], Message]:
        def read(source: Source, label: int) -> Message:
            place = (source.component, source.port)
            while (held := self._with_label(place, label)) is None:
                if source.component not in self._pending:
                    raise RunError(source.component, tick, f"output '{source.port}' of tick {label} was not published")
                self._handle_next(tick, Tick.STEP)
            try:
                return held.decoded()
            except MessageError as error:
                raise RunError(source.component, tick, f"output '{source.port}': {error}") from None

        return read

    def _with_label(self, place: tuple[str, str], label: int) -> _Held | None:
        for held in (self._incoming.get(place), self._held.get(place), self._before.get(place)):
            if held is not None and held.label.tick == label:
                return held
        return None

    def _guard(self, name: str, tick: int | None, call: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        """Call into an inline component; whatever it raises becomes the run's error, with its name and tick."""
        try:
            return call(*args, **kwargs)
        except RunError:
            raise
        except Exception as error:
            raise RunError(name, tick, blame(error)) from error

    def _publish(self, component: str, port: str, label: Label, message: Message) -> None:
        place = (component, port)
        held = self._incoming[place] = _Held(label, message.TYPE, None, message)
        if publisher := self._publishers.get(place):
            publisher.send(held.encoded(), label.encode())

    def _await_answers(self, phase: int, tick: int) -> None:
        while self._pending:
            self._handle_next(tick, phase)

    def _handle_next(self, tick: int, phase: int) -> None:
        assert self._remote is not None
        try:
            event = self._remote.receive()
        except RunError as error:
            self._blame_sender_first(tick, error)
        if isinstance(event, Data):
            self._take_data(event, phase, tick)
        else:
            self._take_done(event, phase, tick)

    def _take_data(self, event: Data, phase: int, tick: int) -> None:
        component, port, label, payload = event
        if label.episode != self._episode:
            return
        expected = self._label_made(component, phase, tick)
        if (label.tick, label.time) != (expected, expected * self._period):
            found = f"output '{port}' is labelled tick {label.tick} at {label.time} ns"
            wanted = f"expected tick {expected} at {expected * self._period} ns"
            raise RunError(component, None if phase == Tick.RESET else tick, f"{found}, {wanted}")
        if (component, port) in self._incoming:
            raise RunError(component, tick, f"output '{port}' was published twice")
        self._incoming[component, port] = _Held(label, self._types[component, port], payload, None)
        if self._pending.get(component, 0) > 0:
            self._pending[component] -= 1
            if self._pending[component] == 0:
                self._answered(component, label.elapsed if phase == Tick.STEP else None)

    def _take_done(self, event: Finished, phase: int, tick: int) -> None:
        component, done = event
        when = None if phase == Tick.RESET else tick
        if not done.ok:
            self._blame_sender_first(tick, RunError(component, when, done.error))
        if (done.phase, done.tick) != (phase, tick):
            raise RunError(
                component, when, f"answered phase {done.phase} of tick {done.tick}, expected {phase} of {tick}"
            )
        if self._pending.get(component) != 0:
            raise RunError(component, when, "sent `done` without being asked: after a step its outputs are its answer")
        self._answered(component, done.elapsed if phase == Tick.STEP else None)

    def _answers(self, component: str, phase: int) -> int:
        """How many outputs are a component's answer; 0 where it answers with `done`."""
        ports = self._graph.members[component].ports
        return len(ports.outputs) if phase == Tick.STEP and ports.kind != "observer" else 0

    def _answered(self, component: str, elapsed: int | None) -> None:
        del self._pending[component]
        assert self._remote is not None
        self._remote.answered(component)
        if elapsed is not None:
            self.elapsed[component].append(elapsed)

    def _blame_sender_first(self, tick: int, error: RunError) -> None:
        """Raise: a component may have failed because of what another one sent it; then that one is to blame."""
        for place in sorted(self._incoming, key=self._order.__getitem__):
            self._verify(place, tick)
        raise error

    def _verify(self, place: tuple[str, str], tick: int | None) -> None:
        """Messages that were not made by our own host are checked before they are believed."""
        if place not in self._unchecked:
            return
        component, port = place
        try:
            check_finite(self._incoming[place].decoded())
        except MessageError as error:
            raise RunError(component, tick, f"output '{port}': {error}") from None

    def _commit(self, tick: int | None) -> None:
        """Hand all that was made to the log in the scenario's order; from now on it is what readers see."""
        made = sorted(self._incoming.items(), key=lambda item: self._order[item[0]])
        for place in self._unchecked:
            if place in self._incoming:
                self._verify(place, tick)
        for place in self._slow_movers:
            if place in self._incoming and place in self._held:
                self._before[place] = self._held[place]
        self._held |= self._incoming
        self._incoming = {}
        if self.commit:
            self.commit([Committed(*place, held.label.time, held.encoded()) for place, held in made])

    def _require(self, components: tuple[str, ...], tick: int | None) -> None:
        """Components that answer with `done` must have published their outputs before."""
        for component in components:
            for output in self._graph.members[component].ports.outputs:
                if (component, output.name) not in self._incoming:
                    raise RunError(component, tick, f"answered without having published output '{output.name}'")

    def _is_slow_mover(self, component: str) -> bool:
        member = self._graph.members[component]
        return member.ports.kind == "mover" and member.every > 1

    def _having(self, kind: str) -> tuple[str, ...]:
        return tuple(n for n in self._steppers if self._graph.members[n].ports.kind == kind)

    def _label_made(self, name: str, phase: int, tick: int) -> int:
        """The tick that outputs made now hold."""
        member = self._graph.members[name]
        return tick + member.every if phase == Tick.STEP and member.ports.kind == "mover" else tick

    def _publishers_of_inline_outputs(self) -> dict[tuple[str, str], Any]:
        """A publisher for every output that is made here and read elsewhere."""
        if self._remote is None:
            return {}
        read_elsewhere = {
            (s.component, s.port)
            for name in self._remote_names
            for sources in self._graph.sources[name].values()
            for s in sources
        }
        return {
            place: self._remote.publisher(*place)
            for place in sorted(read_elsewhere)
            if place[0] not in self._remote_names
        }
