from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from ._errors import Error

__all__ = ["Model", "States", "__version__", "gallery", "outcomes"]
__version__: str

_Floats = NDArray[np.float64]
_Codes = NDArray[np.int8]
_Results = tuple[list[tuple[str, list[str], _Floats]], str, str]
_Parts = tuple[str, str, str | None, list[str], float | None, list[str]]

def gallery() -> list[str]: ...
def outcomes() -> list[tuple[str, str]]: ...
@final
class Model:
    @staticmethod
    def find(source: str) -> Model: ...
    @staticmethod
    def file(
        path: str, literal: bool = False, package_paths: list[str] = ...
    ) -> Model: ...
    @staticmethod
    def parse(text: str) -> Model: ...
    @staticmethod
    def from_parts(parts: _Parts) -> Model: ...
    def parts(self) -> _Parts: ...
    def changed(self, changes: list[str]) -> Model: ...
    @property
    def name(self) -> str: ...
    @property
    def title(self) -> str: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def actuators(self) -> list[tuple[str, str]]: ...
    @property
    def joints(self) -> list[str]: ...
    @property
    def bodies(self) -> list[str]: ...
    @property
    def friction_interfaces(self) -> list[str]: ...
    @property
    def motors(self) -> list[str]: ...
    @property
    def motions(self) -> list[str]: ...
    @property
    def loads(self) -> list[str]: ...
    @property
    def defaults(self) -> tuple[str | None, str]: ...
    @property
    def parameters(self) -> list[tuple[str, float, str]]: ...
    def drawing(self) -> str: ...
    def converted(self, to: str) -> tuple[str, str | None, list[str]]: ...
    def inverse(
        self,
        *,
        motion: str | None = None,
        load: str | None = None,
        friction: str | None = None,
        step: float | None = None,
        threads: int | None = None,
        friction_margin: bool = False,
        progress: Any = None,
    ) -> _Results: ...
    def inverse_report(
        self,
        folder: str | None,
        *,
        motion: str | None = None,
        load: str | None = None,
        friction: str | None = None,
        step: float | None = None,
        threads: int | None = None,
        friction_margin: bool = False,
    ) -> str: ...
    def sweep(
        self,
        columns: list[tuple[str, Any]],
        objectives: list[str],
        *,
        motion: str | None = None,
        load: str | None = None,
        friction: str | None = None,
        step: float | None = None,
        threads: int | None = None,
        progress: Any = None,
    ) -> tuple[list[str], _Floats, list[str]]: ...
    def forward(
        self,
        calls: list[tuple[str, str, float]],
        *,
        until: float | None = None,
        step: float | None = None,
        tolerance: float | None = None,
        law: tuple[float, Any] | None = None,
        stops: list[tuple[str, Any]] = ...,
        progress: Any = None,
    ) -> tuple[_Results, list[tuple[float, str, str, str]], Error | None]: ...
    def forward_report(
        self,
        folder: str | None,
        calls: list[tuple[str, str, float]],
        *,
        until: float | None = None,
        step: float | None = None,
        tolerance: float | None = None,
    ) -> str: ...
    def check(
        self, motion: str | None = None, step: float | None = None, progress: Any = None
    ) -> tuple[str, str]: ...
    def identify(
        self, logs: list[str], options: Any = None, filter: float | None = None
    ) -> tuple[str, str, str | None]: ...
    def breakaway(
        self, motion: str | None = None, load: str | None = None, at: float | None = None
    ) -> tuple[str, str]: ...
    def states(
        self,
        *,
        coordinates: list[str] | None = None,
        motion: str | None = None,
        load: str | None = None,
        friction: str | None = None,
        at: float | None = None,
    ) -> States: ...

@final
class States:
    @property
    def coordinates(self) -> list[tuple[str, str]]: ...
    @property
    def home(self) -> _Floats: ...
    @property
    def load(self) -> str: ...
    def inverse_dynamics(
        self,
        q: Any,
        v: Any = None,
        a: Any = None,
        threads: int | None = None,
        reactions: bool = False,
        frictions: bool = False,
        derivatives: bool = False,
        motors: bool = False,
    ) -> tuple[
        _Codes,
        _Floats,
        _Floats,
        _Floats | None,
        _Floats | None,
        _Floats | None,
        _Floats | None,
        _Floats,
        tuple[_Floats, _Floats, _Floats, NDArray[np.bool_]] | None,
    ]: ...
    def kinematics(
        self, q: Any, v: Any = None, a: Any = None, threads: int | None = None
    ) -> tuple[_Codes, _Floats, _Floats, _Floats, _Floats]: ...
    def jacobian(self, q: Any, threads: int | None = None) -> tuple[_Codes, _Floats]: ...
    def mass_matrix(self, q: Any, threads: int | None = None) -> tuple[_Codes, _Floats]: ...
