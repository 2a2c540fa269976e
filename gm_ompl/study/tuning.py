"""Tuning a planner's declared parameters: the only import of optuna.

Trials are made one after the other, each trial's runs on all workers. What a trial tries depends on
the trials finished before it and on its place among them alone. So a study that was killed goes on
as if nothing had happened: finished trials come from its journal, finished runs from the store.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np

from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.forks import RunLimits
from gm_ompl.planners.parameters import Parameter, Value
from gm_ompl.planners.registry import PLANNERS, make_planner
from gm_ompl.reading import Kind, check_ordinary
from gm_ompl.scenario.scenario import Scenario
from gm_ompl.study.compare import compare, make_tasks
from gm_ompl.study.scores import MEASURES, TOLERANCE, Gain, gain, score
from gm_ompl.study.store import JournalLock, Store, writing_journal
from gm_ompl.study.task import Task, code_version
from gm_ompl.study.workers import Executor

OBJECTIVES: Mapping[str, tuple[str, ...]] = {
    **{name: (name,) for name in MEASURES}, "both": ("decisions", "cost"),
}  # fmt: skip
"""What may be asked for, and the measures that are then made small."""

FRESH = 1_000_000  # held-out runs have seeds from here on: no trial was chosen by them

Values: TypeAlias = dict[str, Value]
Watch: TypeAlias = Callable[[int, int], None]  # called with (trials finished, trials in all)


@dataclass(frozen=True, eq=False)
class Design:
    """What is tuned, on what, by what."""

    planner: str  # its name
    training: Sequence[Scenario]  # scenarios that trials are scored on
    held_out: Sequence[Scenario]  # scenarios that the winner is scored on
    seeds: int  # runs per scenario and trial
    limits: RunLimits  # of each run
    objective: str  # a key of ``OBJECTIVES``
    trials: int  # how many
    seed: int  # of the search over parameters

    def __post_init__(self) -> None:
        shared = {s.name for s in self.training} & {s.name for s in self.held_out}
        if shared or not self.held_out:
            wrong = ", ".join(sorted(shared)) or "none"
            raise InputError(f"--hold-out: {wrong}: name scenarios that are not trained on")
        make_planner(self.planner)
        if not searched(PLANNERS[self.planner].parameters):
            raise InputError(f"--planner {self.planner}: has no parameters to tune")

    def tasks(self, parameters: Values, *, held_out: bool = False) -> tuple[Task, ...]:
        """Return the runs with these parameters."""
        scenarios = self.held_out if held_out else self.training
        made = make_tasks(
            scenarios, [self.planner], self.seeds, self.limits, {self.planner: parameters},
            tolerance=TOLERANCE in OBJECTIVES[self.objective],
        )  # fmt: skip
        return tuple(replace(task, seed=task.seed + FRESH) for task in made) if held_out else made

    @property
    def key(self) -> str:
        """What decides the study's course, hashed: studies of one journal are told apart by it."""
        tasks = [task.to_dict() for task in self.tasks({})]
        text = json.dumps([tasks, self.objective, self.seed, code_version()], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


JOURNAL = Kind("journal of trials", "JSON lines, as tune writes it", 2**30)


@dataclass(frozen=True)
class Tried:
    """A finished trial: its parameters, and its value of every measure of the objective."""

    parameters: Values
    values: tuple[float, ...]


@dataclass(frozen=True)
class Tuned:
    """What tuning found."""

    trials: tuple[Tried, ...]  # all, in order; the first has the defaults
    best: int  # the winner's place among them
    front: tuple[int, ...]  # places of the trials that no other beats in every measure
    importances: Mapping[str, float]  # see ``importances``
    # per measure, the winner against the defaults on the held-out scenarios
    gains: Mapping[str, Gain]
    study: Any  # optuna's, for its charts


def searched(parameters: Sequence[Parameter]) -> tuple[Parameter, ...]:
    """Return the parameters with a finite range of values to search; the rest keep defaults."""
    return tuple(
        parameter
        for parameter in parameters
        if parameter.kind in (bool, str) or None not in (parameter.low, parameter.high)
    )


def tune(
    design: Design, store: Store, executor: Executor, journal: Path, watch: Watch | None = None
) -> Tuned:
    """Make the trials that the journal does not hold yet, and score the winner.

    Raises:
        MissingExtraError: optuna is not installed.
    """
    optuna = _optuna()
    with writing_journal(journal):
        study = _study(optuna, design, journal)
    base = compare(design.tasks({}), store, executor)
    finished = _finished(optuna, study)
    while len(finished) < design.trials:
        if watch is not None:
            watch(len(finished), design.trials)
        with writing_journal(journal):
            trial = _ask(optuna, study, design, len(finished))
            values = _suggested(trial, PLANNERS[design.planner].parameters)
        records = compare(design.tasks(values), store, executor)
        scores = [score(name, records, base) for name in OBJECTIVES[design.objective]]
        with writing_journal(journal):
            study.tell(trial, scores)
        finished = _finished(optuna, study)
    if watch is not None:
        watch(len(finished), design.trials)
    trials = tuple(Tried(dict(t.params), tuple(t.values)) for t in finished[: design.trials])
    best_numbers = {trial.number for trial in study.best_trials}
    front = tuple(k for k, t in enumerate(finished[: design.trials]) if t.number in best_numbers)
    best = min(front, key=lambda place: (sum(map(math.log, trials[place].values)), place))
    settings: tuple[Values, Values] = ({}, trials[best].parameters)
    old, new = (compare(design.tasks(s, held_out=True), store, executor) for s in settings)
    known = [name for name in MEASURES if name != TOLERANCE or old[0].tolerance is not None]
    gains = {name: gain(name, old, new) for name in known}
    return Tuned(trials, best, front, importances(trials), gains, study)


def _study(optuna: ModuleType, design: Design, journal: Path) -> Any:
    """Open or begin the study; a trial that was under way when it was killed is given up."""
    if os.path.lexists(journal):
        check_ordinary(journal, JOURNAL)
    backend = optuna.storages.journal.JournalFileBackend(str(journal), JournalLock(journal))
    try:
        study = optuna.create_study(
            storage=optuna.storages.JournalStorage(backend),
            study_name=design.key,
            directions=["minimize"] * len(OBJECTIVES[design.objective]),
            load_if_exists=True,
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:  # whatever its lines say
        raise InputError(
            f"{journal}: is damaged ({error}); name another -o, or delete the file"
        ) from None
    state = optuna.trial.TrialState
    for trial in study.get_trials(states=(state.RUNNING,)):
        study.tell(trial.number, state=state.FAIL)
    return study


def _finished(optuna: ModuleType, study: Any) -> list[Any]:
    trials: list[Any] = study.get_trials(states=(optuna.trial.TrialState.COMPLETE,))
    return trials


def _ask(optuna: ModuleType, study: Any, design: Design, place: int) -> Any:
    """Return the next trial; the first has the defaults."""
    parameters = searched(PLANNERS[design.planner].parameters)
    # Seeded by its place: what a killed call had drawn does not matter.
    study.sampler = optuna.samplers.TPESampler(seed=design.seed * 1_000_003 + place)
    if place == 0 and not study.get_trials(states=(optuna.trial.TrialState.WAITING,)):
        study.enqueue_trial({parameter.name: parameter.default for parameter in parameters})
    return study.ask()


def _suggested(trial: Any, parameters: Sequence[Parameter]) -> Values:
    values: Values = {}
    for parameter in searched(parameters):
        if parameter.kind in (bool, str):
            choices = parameter.choices if parameter.kind is str else (False, True)
            values[parameter.name] = trial.suggest_categorical(parameter.name, choices)
            continue
        suggest = trial.suggest_int if parameter.kind is int else trial.suggest_float
        assert parameter.low is not None and parameter.high is not None
        low, high = parameter.kind(parameter.low), parameter.kind(parameter.high)
        by_factors = parameter.logarithmic and parameter.low > 0
        values[parameter.name] = suggest(parameter.name, low, high, log=by_factors)
    return values


def importances(trials: Sequence[Tried]) -> dict[str, float]:
    """Return, per parameter, how much of the first measure it explains alone; largest first.

    That is the share of the variance of the measure's logarithm that a parabola in the parameter's
    rank accounts for: 0 where nothing differs, 1 where nothing else matters.
    """
    y = np.log([trial.values[0] for trial in trials])
    y = y - y.mean()
    shares = {}
    for name in trials[0].parameters:
        values = [trial.parameters[name] for trial in trials]
        _, ranks = np.unique(np.array(values), return_inverse=True)
        x = ranks / max(1, ranks.max())
        basis = np.stack([np.ones(len(x)), x, x * x], axis=1)
        rest = y - basis @ np.linalg.lstsq(basis, y, rcond=None)[0]
        spread = float(y @ y)
        shares[name] = max(0.0, 1.0 - float(rest @ rest) / spread) if spread > 0.0 else 0.0
    return dict(sorted(shares.items(), key=lambda item: -item[1]))


def charts(study: Any, measures: tuple[str, ...]) -> Iterator[Any]:
    """Yield a study's history for every measure, and of two measures the front."""
    drawing = _optuna().visualization

    def measured(column: int) -> Callable[[Any], float]:
        return lambda trial: float(trial.values[column])

    for k, name in enumerate(measures):
        yield drawing.plot_optimization_history(
            study, target=measured(k), target_name=f"{name}, trial 0 has the defaults"
        )
    if len(measures) == 2:
        yield drawing.plot_pareto_front(study, target_names=list(measures))


def _optuna() -> ModuleType:
    try:
        import optuna
    except ImportError:
        raise MissingExtraError("optuna", "tune") from None
    optuna.logging.disable_default_handler()  # what matters is said here
    module: ModuleType = optuna
    return module
