"""Who packs the parts and strips of a mesh, who keeps them, and who hears how far they are."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain
from typing import TypeVar

from bubblemesh.packing.rounds import Record
from bubblemesh.parts.packing import kept_part, packed_part
from bubblemesh.parts.part import Margin
from bubblemesh.parts.seams import PackedStrip, packed_again
from bubblemesh.parts.store import Store
from bubblemesh.parts.work import Crew, Job
from bubblemesh.records import record

T = TypeVar("T")
JobOf = Callable[[int], Job]  # makes the job with a number when a worker is to do it


@record
class Workshop:
    """The crew that packs the parts and strips of a mesh, the store that keeps the parts, and listeners."""

    crew: Crew
    store: Store
    on_done: Callable[[Record], None]  # is called with each part, in their order, and with each pass over the seams
    on_share: Callable[[float], None]  # is called with the share of all that is done

    def margins(self, job: JobOf, work: Sequence[float], figured: bool) -> list[Margin]:
        """Pack the parts that are not kept yet, and keep them: the margin of each part.

        The job of a part has a `PartJob`; ``work`` has the share of each in all that is to be done. Parts that are kept
        without figures, for another output, are packed again if they have to be ``figured``.
        """
        kept = ((number, self.store.margin(number)) for number in range(len(work)))
        done = ((number, margin) for number, margin in kept if margin is not None and not margin.record.late)
        known = {number: margin for number, margin in done if margin.figured or not figured}
        left = [number for number in range(len(work)) if number not in known]
        margins = list[Margin]()
        for margin in self._in_order(chain(known.items(), self._fresh(job, left, work)), work):
            self.on_done(margin.record)
            margins.append(margin)
        return margins

    def strips(self, job: JobOf, work: Sequence[float], done: float) -> list[PackedStrip]:
        """Pack strips once more: each as it is then.

        The job of a strip has the arguments of `packed_again`; ``work`` has the share of each in all, of which the
        share ``done`` is done before.
        """
        strips = list(self._in_order(self._results(packed_again, job, range(len(work)), work), work, done))
        if strips:
            self.on_done(Record.together(strip.record for strip in strips))
        return strips

    def _fresh(self, job: JobOf, numbers: Iterable[int], work: Sequence[float]) -> Iterator[tuple[int, Margin]]:
        """Pack parts and keep them: where they are packed if that can be, as most of a part is nothing but kept."""

        def keeping(number: int) -> Job:
            what, (part,) = job(number)
            return Job(what, (self.store, number, part))

        if self.store.shared:
            yield from self._results(kept_part, keeping, numbers, work)
            return
        for number, part in self._results(packed_part, job, numbers, work):
            self.store.keep(number, part)
            yield number, part.margin

    def _results(
        self, function: Callable[..., T], job: JobOf, numbers: Iterable[int], work: Sequence[float]
    ) -> Iterator[tuple[int, T]]:
        """Number and result of each of some jobs, as they come; the longest are begun first."""
        order = sorted(numbers, key=lambda number: -work[number])
        return ((order[place], result) for place, result in self.crew(function, map(job, order)))

    def _in_order(self, results: Iterable[tuple[int, T]], work: Sequence[float], done: float = 0.0) -> Iterator[T]:
        """Results in the order of their numbers; the share of all that is done is reported as they come."""
        waiting, given = dict[int, T](), 0
        for number, result in results:
            waiting[number] = result
            done += work[number]
            self.on_share(min(done, 1.0))
            while given in waiting:
                yield waiting.pop(given)
                given += 1
