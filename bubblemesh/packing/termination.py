"""When to stop: after a number of rounds, or once the population has settled (section 2.4 of the paper)."""

from collections.abc import Sequence
from typing import Annotated, Protocol

from annotated_types import Ge, Gt, Le
from typing_extensions import Doc

from bubblemesh.records import record

Rounds = Annotated[int, Gt(0), Le(10_000), Doc("number of rounds, at most")]
Iterations = Annotated[
    int, Gt(0), Le(100_000), Doc("steps of a round; at the end of the published methods as many again")
]
Tolerance = Annotated[float, Ge(0), Doc("relative change of the number of bubbles that counts as settled")]

Counts = Sequence[tuple[int, int]]  # numbers of bubbles before and after each round of a stage so far


class Termination(Protocol):
    """When the rounds on a level end."""

    def __call__(self, counts: Counts) -> str | None:
        """Reason to stop, None to go on."""

    def steps(self, opening: bool) -> int:
        """Steps of a round; ``opening`` is the first one of all."""

    def expected_steps(self, opening: bool) -> int:
        """About how many steps it takes until it says stop, the last relaxation included."""


@record
class FixedRounds:
    """Stop after the given number of rounds."""

    rounds: Rounds = 10
    iterations: Iterations = 250

    def __call__(self, counts: Counts) -> str | None:
        return f"all {self.rounds} rounds done" if len(counts) >= self.rounds else None

    def steps(self, opening: bool) -> int:
        return self.iterations

    def expected_steps(self, opening: bool) -> int:
        return (self.rounds + 1) * self.iterations


@record
class SelfAdaptive(FixedRounds):
    """Stop also when the relative change of the population was small in two rounds one after the other.

    With N1 and N2 bubbles before and after a round it is small if abs(N1 - N2) <= tolerance * N1.
    """

    tolerance: Tolerance = 0.005

    def __call__(self, counts: Counts) -> str | None:
        settled = [abs(before - after) <= self.tolerance * before for before, after in counts[-2:]]
        if len(settled) == 2 and all(settled):
            return f"population changed by at most {self.tolerance:.1%} in two rounds"
        return super().__call__(counts)


@record
class Settled(FixedRounds):
    """Stop a level also when a single round has changed the population by little."""

    rounds: Rounds = 8
    iterations: Iterations = 12
    opening_iterations: Annotated[
        int, Gt(0), Le(100_000), Doc("steps of the first round, whose bubbles are without any order")
    ] = 100
    tolerance: Tolerance = 0.005

    def steps(self, opening: bool) -> int:
        return self.opening_iterations if opening else self.iterations

    def expected_steps(self, opening: bool) -> int:
        return self.steps(opening) + self.iterations

    def __call__(self, counts: Counts) -> str | None:
        before, after = counts[-1]
        if abs(before - after) <= self.tolerance * before:
            return f"population changed by at most {self.tolerance:.1%} in a round"
        # Reports number the rounds on from level to level.
        return f"all {self.rounds} rounds of the last level done" if len(counts) >= self.rounds else None
