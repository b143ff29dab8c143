"""A process that answers, and is replaced when it takes too long or dies."""

from collections.abc import Callable, Mapping
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

import psutil

COMPILING = 10.0  # times as long an answer may take if kernels are compiled or radiation is fitted


class Question(NamedTuple):
    """Whom to ask, how much CPU time the answer may take [s], what it is if the process dies, and
    how many times as long it may take the first time."""

    answer: Callable[[Any], Any]
    limit: float
    died: Any = None
    patience: float = 1.0


class Worker:
    """A process that answers ``questions`` one after the other."""

    def __init__(self, questions: Mapping[str, Question]) -> None:
        self._questions = dict(questions)
        self._start()

    def ask(self, what: str, about: Any) -> Any:
        """The answer; None if it takes too long even when all is compiled and fitted."""
        usual = self._questions[what].limit
        patience = self._questions[what].patience
        for limit in (usual, patience * usual, usual) if patience > 1.0 else (usual,):
            answer = self._answer(what, about, limit)
            if answer is not None and limit == usual:
                return answer
        return None

    def _start(self) -> None:
        context = get_context("spawn")
        self._pipe, other = context.Pipe()
        answers = {what: question.answer for what, question in self._questions.items()}
        self._process = context.Process(target=_serve, args=(other, answers), daemon=True)
        self._process.start()
        other.close()

    def _answer(self, what: str, about: Any, limit: float) -> Any:
        self._pipe.send((what, about))
        used = psutil.Process(self._process.pid)
        begin = sum(used.cpu_times()[:2])
        while not self._pipe.poll(0.5):
            if not self._process.is_alive():
                self._start()
                return self._questions[what].died
            if sum(used.cpu_times()[:2]) - begin > limit:
                self._process.kill()
                self._process.join()
                self._start()
                return None
        try:
            return self._pipe.recv()
        except EOFError:
            self._start()
            return self._questions[what].died


def _serve(pipe: Connection, answers: Mapping[str, Callable[[Any], Any]]) -> None:
    """Answer what is asked, in the worker's process, until nobody asks any more."""
    while True:
        try:
            what, about = pipe.recv()
        except EOFError:
            return
        pipe.send(answers[what](about))
