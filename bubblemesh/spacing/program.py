"""Programs: functions of x and y as steps, of which equal ones are taken once however many need their values."""

from collections.abc import Callable, Hashable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from bubblemesh.records import record

X, Y = 0, 1  # numbers of the values that are given

Step = tuple[Callable[..., Any], tuple[int, ...]]  # what is called, and the numbers of the values that it takes


class ProgramBuilder:
    """Collects steps: each value has a number, and equal steps have the same one. What is constant is known at once."""

    def __init__(self) -> None:
        self._known: dict[int, Any] = {}
        self._steps: dict[int, Step] = {}
        self._numbers: dict[Hashable, int] = {}

    def constant(self, value: Any) -> int:
        """The number of a constant."""
        number = self._number((np.asarray(value).tobytes(),))
        self._known[number] = value
        return number

    def step(self, call: Callable[..., Any], arguments: Sequence[int]) -> int:
        """The number of the value that a call gives of the values with some numbers."""
        if arguments and all(number in self._known for number in arguments):
            with np.errstate(all="ignore"):
                return self.constant(call(*[self._known[number] for number in arguments]))
        number = self._number((id(call), *arguments))  # a call that is kept, so that no other one has its id
        self._steps[number] = call, tuple(arguments)
        return number

    def added(self, program: "Program") -> list[int]:
        """The numbers here of the results of a program."""
        numbers = {X: X, Y: Y} | {number: self.constant(value) for number, value in program.known.items()}
        for number, (call, arguments) in program.steps.items():
            numbers[number] = self.step(call, [numbers[argument] for argument in arguments])
        return [numbers[result] for result in program.results]

    def program(self, *results: int) -> "Program":
        """The program whose results are the values with some numbers."""
        return Program(self._known, self._steps, results)

    def _number(self, key: Hashable) -> int:
        return self._numbers.setdefault(key, len(self._numbers) + 2)


@record(eq=False)
class Program:
    """A function of x and y that gives the values with some numbers."""

    known: dict[int, Any]  # constants
    steps: dict[int, Step]  # in their order
    results: tuple[int, ...]

    @property
    def is_constant(self) -> bool:
        """Whether the results are the same for any x and y."""
        return all(result in self.known for result in self.results)

    def __call__(self, x: Any, y: Any) -> list[Any]:
        """The results at x and y."""
        values = {**self.known, X: x, Y: y}
        for number, call, arguments, done in self._order:
            values[number] = call(*[values[argument] for argument in arguments])
            for used in done:
                del values[used]
        return [values[result] for result in self.results]

    @cached_property
    def _order(self) -> list[tuple[int, Callable[..., Any], tuple[int, ...], set[int]]]:
        """Steps with the numbers of those values that no later one needs: all of them would take much memory."""
        needed, order = set(self.results), []
        for number, (call, arguments) in reversed(self.steps.items()):
            order.append((number, call, arguments, (set(arguments) & self.steps.keys()) - needed))
            needed |= set(arguments)
        return order[::-1]
