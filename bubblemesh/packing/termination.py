"""When to stop: after a number of rounds, or once the population has settled (section 2.4 of the paper)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Gt


@dataclass(frozen=True)
class FixedRounds:
    """Stop after ``rounds`` rounds of ``iterations`` steps; the last round relaxes for as many steps again."""

    rounds: Annotated[int, Gt(0)] = 10
    iterations: Annotated[int, Gt(0)] = 250

    def __call__(self, counts: Sequence[tuple[int, int]]) -> str | None:
        """Reason to stop, given the numbers of bubbles before and after each round so far; None to go on."""
        return f"all {self.rounds} rounds done" if len(counts) >= self.rounds else None

    def steps(self, opening: bool) -> int:
        """Steps of a round; ``opening`` is the first one of all."""
        return self.iterations

    def expected_steps(self, opening: bool) -> int:
        """About how many steps it takes until it says stop, the last relaxation included."""
        return (self.rounds + 1) * self.iterations


@dataclass(frozen=True)
class SelfAdaptive(FixedRounds):
    """Stop also when the relative change |N1 - N2| <= tolerance * N1 has held in two rounds one after the other."""

    tolerance: Annotated[float, Ge(0)] = 0.005

    def __call__(self, counts: Sequence[tuple[int, int]]) -> str | None:
        """Reason to stop, given the numbers of bubbles before and after each round so far; None to go on."""
        settled = [abs(before - after) <= self.tolerance * before for before, after in counts[-2:]]
        if len(settled) == 2 and all(settled):
            return f"population changed by at most {self.tolerance:.1%} in two rounds"
        return super().__call__(counts)


@dataclass(frozen=True)
class Settled(FixedRounds):
    """Stop a level when a round has changed the number of bubbles by at most ``tolerance`` times it."""

    rounds: Annotated[int, Gt(0)] = 8
    iterations: Annotated[int, Gt(0)] = 12
    opening_iterations: Annotated[int, Gt(0)] = 100
    tolerance: Annotated[float, Ge(0)] = 0.005

    def steps(self, opening: bool) -> int:
        """Steps of a round; the opening one has more, since the initial bubbles are without any order."""
        return self.opening_iterations if opening else self.iterations

    def expected_steps(self, opening: bool) -> int:
        """About how many steps it takes until it says stop."""
        return self.steps(opening) + self.iterations

    def __call__(self, counts: Sequence[tuple[int, int]]) -> str | None:
        """Reason to stop, given the numbers of bubbles before and after each round so far; None to go on."""
        before, after = counts[-1]
        if abs(before - after) <= self.tolerance * before:
            return f"population changed by at most {self.tolerance:.1%} in a round"
        return super().__call__(counts)
