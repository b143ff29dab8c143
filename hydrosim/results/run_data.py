"""Data of a run that has just ended, read as an `xarray.Dataset` is, without loading xarray.

xarray and pandas take longer to load than a short run takes, and 90 MB. What the end of a run needs
(values, attributes, selections, largest values, a file) is answered from numpy's arrays. All else
is answered by the `xarray.Dataset` of the same content, which is made for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, cast

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from hydrosim.results.dataset import new_dataset

if TYPE_CHECKING:
    from pathlib import Path

    import xarray as xr


class VariableContent(NamedTuple):
    """What a variable holds."""

    dims: tuple[str, ...]
    values: np.ndarray
    attributes: dict[str, Any]


def new_run_data(data: Mapping[str, Any], coords: Mapping[str, Any]) -> xr.Dataset:
    """`RunData` of tuples (dims, values) and (dims, values, attributes). Coordinates along their
    own dimension come first, as in `new_dataset`."""
    contents = {name: _content_of(content) for name, content in {**data, **coords}.items()}
    first = {name: content for name, content in contents.items() if content.dims == (name,)}
    return cast("xr.Dataset", RunData({**first, **_leave_out(contents, first)}, coords, {}))


def as_xarray(run: xr.Dataset) -> xr.Dataset:
    """The `xarray.Dataset` of a run; that itself if it is one."""
    return run._to_xarray() if isinstance(run, RunData) else run


class RunVariable(NDArrayOperatorsMixin):
    """A variable, read as an `xarray.DataArray`, which ``make_array`` gives. Of the dimensions
    ``chosen`` it has not all labels of the run."""

    def __init__(
        self,
        content: VariableContent,
        run: RunData,
        make_array: Callable[[], Any],
        chosen: frozenset[str] = frozenset(),
    ) -> None:
        self.dims = content.dims
        self.values = np.asarray(content.values)
        self.attrs = content.attributes
        self._run = run
        self._to_xarray = make_array
        self._chosen = chosen

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.array(self.values, dtype=dtype, copy=copy)

    def __float__(self) -> float:
        return float(self.values)

    def __int__(self) -> int:
        return int(self.values)

    def __bool__(self) -> bool:
        return bool(self.values)

    def __len__(self) -> int:
        return len(self.values)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._to_xarray())

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            dims = self._run[key].dims if key in self._run.coords else (key,)
            has_all_labels = {*dims} <= {*self.dims} - self._chosen and key in self._run
            return self._run[key] if has_all_labels else self._to_xarray()[key]
        keys = key if isinstance(key, tuple) else (key,)
        return self.isel(dict(zip(self.dims, keys, strict=False)))

    def __getattr__(self, name: str) -> Any:
        return _answer_with(self._to_xarray, name)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method == "__call__" and not options and all(map(self._has_same_labels, inputs)):
            values = ufunc(*map(_values_of, inputs))
            return self._derive(self.dims, values, lambda: ufunc(*map(_as_arrays, inputs)))
        return getattr(ufunc, method)(*map(_as_arrays, inputs), **options)

    def _has_same_labels(self, value: Any) -> bool:
        """Whether a value is a number, or has the same labels in the same order."""
        if isinstance(value, RunVariable):
            same = value.dims == self.dims and value._run is self._run
            return value is self or (same and not value._chosen | self._chosen)
        return isinstance(value, int | float | np.number)

    def _derive(
        self,
        dims: tuple[str, ...],
        values: Any,
        make_array: Callable[[], Any],
        chosen: frozenset[str] = frozenset(),
    ) -> RunVariable:
        content = VariableContent(dims, values, self.attrs)
        return RunVariable(content, self._run, make_array, self._chosen | chosen)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return self.values.shape

    @property
    def size(self) -> int:
        """Number of values."""
        return self.values.size

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the values."""
        return self.values.dtype

    def item(self) -> Any:
        """The only value."""
        return self.values.item()

    def isel(self, chosen: Mapping[str, Any] | None = None, **by_name: Any) -> RunVariable:
        """Values at indices along dimensions: whole numbers, slices, or arrays (also of truth)."""
        places = {dim: _values_of(index) for dim, index in {**(chosen or {}), **by_name}.items()}
        values = self.values
        for axis, dim in reversed([*enumerate(self.dims)]):
            if dim in places:
                values = values[(slice(None),) * axis + (places[dim],)]
        several = {dim for dim, i in places.items() if isinstance(i, slice) or np.ndim(i)}
        dims = tuple(dim for dim in self.dims if dim not in places or dim in several)
        here = {dim: index for dim, index in places.items() if dim in self.dims}
        return self._derive(dims, values, lambda: self._to_xarray().isel(here), frozenset(several))

    def sel(self, chosen: Mapping[str, Any] | None = None, **by_name: Any) -> Any:
        """Values at labels along dimensions: names, numbers, or arrays of them."""
        labels = {**(chosen or {}), **by_name}
        places = None if self._chosen & labels.keys() else self._run._places_of(labels)
        return self._to_xarray().sel(labels) if places is None else self.isel(places)

    def transpose(self, *dims: Any) -> RunVariable:
        """Dimensions in another order; ``...`` stands for those without a name."""
        rest = [dim for dim in self.dims if dim not in dims]
        order = [name for dim in dims for name in (rest if dim is ... else [dim])]
        names = tuple(order or self.dims[::-1])
        values = self.values.transpose([self.dims.index(name) for name in names])
        return self._derive(names, values, lambda: self._to_xarray().transpose(*dims))

    def copy(self, data: np.ndarray) -> RunVariable:
        """Other values for the same labels."""
        return self._derive(self.dims, data, lambda: self._to_xarray().copy(data=data))

    def clip(self, min: float | None = None, max: float | None = None) -> RunVariable:
        """Values within limits."""
        values = np.clip(self.values, min, max)
        return self._derive(self.dims, values, lambda: self._to_xarray().clip(min, max))

    def min(self, dim: str | None = None) -> RunVariable:
        """Smallest value, along all dimensions or one."""
        return self._reduce_along(np.fmin.reduce, "min", dim)

    def max(self, dim: str | None = None) -> RunVariable:
        """Largest value, along all dimensions or one."""
        return self._reduce_along(np.fmax.reduce, "max", dim)

    def _reduce_along(self, reduce: Callable[..., Any], name: str, dim: str | None) -> RunVariable:
        axis = None if dim is None else self.dims.index(dim)
        dims = tuple(d for d in self.dims if dim not in (d, None))
        values = reduce(self.values, axis=axis)
        return self._derive(dims, values, lambda: getattr(self._to_xarray(), name)(dim))


class RunData:
    """Variables by name, among them the ``coordinates``, and attributes, read as an
    `xarray.Dataset`."""

    def __init__(
        self,
        contents: Mapping[str, VariableContent],
        coordinates: Iterable[str],
        attributes: Mapping[str, Any],
    ) -> None:
        self._contents = {**contents}
        self._coordinates = [*coordinates]
        self.attrs = {**attributes}

    def __setitem__(self, name: str, content: Any) -> None:
        self._contents[name] = _content_of(content)

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            return RunVariable(self._contents[key], self, lambda: self._to_xarray()[key])
        dims = {dim for name in key for dim in self._contents[name].dims}
        along = (name for name in self._coordinates if dims.issuperset(self._contents[name].dims))
        names = dict.fromkeys([*key, *along])
        return self._with_contents({name: self._contents[name] for name in names})

    def __contains__(self, name: object) -> bool:
        return name in self._contents

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("_") and name in self._contents:
            return self[name]
        return _answer_with(self._to_xarray, name)

    @property
    def variables(self) -> VariablesByName:
        """All variables, with the coordinates."""
        return VariablesByName(self, self._contents)

    @property
    def coords(self) -> VariablesByName:
        """The coordinates."""
        names = [name for name in self._contents if name in self._coordinates]
        return VariablesByName(self, dict.fromkeys(names))

    @property
    def data_vars(self) -> VariablesByName:
        """The variables that are no coordinates."""
        return VariablesByName(self, _leave_out(self._contents, self._coordinates))

    @property
    def sizes(self) -> dict[str, int]:
        """Lengths of the dimensions."""
        contents = self._contents.values()
        return {dim: n for x in contents for dim, n in zip(x.dims, x.values.shape, strict=True)}

    dims = sizes

    def isel(self, chosen: Mapping[str, Any] | None = None, **by_name: Any) -> RunData:
        """All variables at indices along dimensions."""
        places = {**(chosen or {}), **by_name}
        return self._with_contents(
            {name: _content_of(x.isel(places)) for name, x in self.variables.items()}
        )

    def sel(self, chosen: Mapping[str, Any] | None = None, **by_name: Any) -> Any:
        """All variables at labels along dimensions."""
        labels = {**(chosen or {}), **by_name}
        places = self._places_of(labels)
        return self._to_xarray().sel(labels) if places is None else self.isel(places)

    def assign(self, variables: Mapping[str, Any]) -> RunData:
        """The run with further variables."""
        return self._with_contents(
            {name: _content_of(content) for name, content in variables.items()}, True
        )

    def assign_coords(self, coords: Mapping[str, Any] | None = None, **by_name: Any) -> RunData:
        """The run with further coordinates: tuples, or labels along the dimension of their name."""
        added = {**(coords or {}), **{name: (name, values) for name, values in by_name.items()}}
        made = self.assign(added)
        made._coordinates += [*added]
        return made

    def assign_attrs(self, attributes: Mapping[str, Any] | None = None, **more: Any) -> RunData:
        """The run with further attributes."""
        made = self._with_contents(self._contents)
        made.attrs |= {**(attributes or {}), **more}
        return made

    def drop_vars(self, names: Iterable[str]) -> RunData:
        """The run without these variables."""
        return self._with_contents(_leave_out(self._contents, names))

    def to_netcdf(
        self,
        path: Path,
        mode: Literal["w", "a"] = "w",
        group: str | None = None,
        encoding: Mapping[str, Mapping[str, Any]] | None = None,
        **options: Any,
    ) -> None:
        """Write the file, or the group of a file, that xarray writes. Of an ``encoding``, only a
        `_FillValue` counts."""
        if any(x.values.dtype.kind not in STORED_KINDS for x in self._contents.values()):
            self._to_xarray().to_netcdf(path, mode=mode, group=group, encoding=encoding, **options)
            return
        import netCDF4

        with netCDF4.Dataset(path, mode, format="NETCDF4") as whole:
            file = whole.createGroup(group) if group else whole
            named = {name: self._coordinates_of(name) for name in self.data_vars}
            of_none = {*self._auxiliary_coordinates()}.difference(*named.values())
            file.setncatts({**self.attrs, **_coordinates_attribute(of_none)})
            for dim, size in self.sizes.items():
                file.createDimension(dim, size)
            for name, (dims, values, attributes) in self._contents.items():
                is_text = values.dtype.kind in "OU"
                fill = np.nan if values.dtype.kind == "f" else None
                fill = (encoding or {}).get(name, {}).get("_FillValue", fill)
                stored = file.createVariable(
                    name, str if is_text else values.dtype, dims, fill_value=fill
                )
                stored.set_auto_maskandscale(False)
                stored.setncatts({**attributes, **_coordinates_attribute(named.get(name, ()))})
                stored[...] = values.astype(object) if is_text else values

    def _auxiliary_coordinates(self) -> list[str]:
        """Coordinates that are not along the dimension of their name."""
        return [name for name in self._coordinates if self._contents[name].dims != (name,)]

    def _coordinates_of(self, name: str) -> list[str]:
        """Of these coordinates, those that belong to a variable."""
        dims = {*self._contents[name].dims}
        return [k for k in self._auxiliary_coordinates() if dims.issuperset(self._contents[k].dims)]

    def _with_contents(
        self, contents: Mapping[str, VariableContent], more: bool = False
    ) -> RunData:
        """Run with these variables alone, or with these ``more``."""
        variables = {**self._contents, **contents} if more else contents
        coordinates = [name for name in self._coordinates if name in variables]
        return RunData(variables, coordinates, self.attrs)

    def _places_of(self, labels: Mapping[str, Any]) -> dict[str, Any] | None:
        """Indices of labels along dimensions; None if xarray has to find them."""
        places: dict[str, Any] = {}
        for dim, label in labels.items():
            chosen = _values_of(label)
            if isinstance(chosen, slice) or dim not in self._contents:
                return None
            values = np.asarray(chosen)
            if values.dtype.kind == "b":
                places[dim] = values
                continue
            index = {text: k for k, text in enumerate(self._contents[dim].values.tolist())}
            if not index.keys() >= {*values.ravel().tolist()}:
                return None
            indices = [index[text] for text in values.ravel().tolist()]
            places[dim] = np.array(indices, int) if values.ndim else indices[0]
        return places

    def _to_xarray(self) -> xr.Dataset:
        contents = self._contents
        coords = {name: contents[name] for name in contents if name in self._coordinates}
        made = new_dataset(_leave_out(contents, coords), coords, self.attrs)
        return made if [*made.variables] == [*contents] else made[[*contents]]


class VariablesByName(Mapping[str, RunVariable]):
    """Some variables of a run, each made when it is asked for."""

    def __init__(self, run: RunData, names: Mapping[str, Any]) -> None:
        self._run = run
        self._names = names

    def __getitem__(self, name: str) -> RunVariable:
        if name not in self._names:
            raise KeyError(name)
        variable: RunVariable = self._run[name]
        return variable

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)


STORED_KINDS = "fiuOU"
"""Kinds of numpy's types that a file holds as they are."""


def _content_of(content: Any) -> VariableContent:
    """Content from a variable, or from a tuple (dims, values) with attributes or without."""
    if isinstance(content, VariableContent):
        return content
    if hasattr(content, "attrs"):
        return VariableContent(content.dims, content.values, content.attrs)
    dims, values, *attributes = content
    names = (dims,) if isinstance(dims, str) else tuple(dims)
    return VariableContent(names, np.asarray(values), dict(*attributes))


def _leave_out(contents: Mapping[str, Any], names: Iterable[str]) -> dict[str, Any]:
    left_out = {*names}
    return {name: content for name, content in contents.items() if name not in left_out}


def _coordinates_attribute(names: Iterable[str]) -> dict[str, str]:
    return {"coordinates": " ".join(sorted(names))} if names else {}


def _values_of(value: Any) -> Any:
    return value.values if hasattr(value, "values") else value


def _as_arrays(value: Any) -> Any:
    return value._to_xarray() if isinstance(value, RunVariable | RunData) else value


def _answer_with(make: Callable[[], Any], name: str) -> Any:
    """The attribute or method ``name`` of what ``make`` gives; the method takes `RunVariable`."""
    if name.startswith("_"):
        raise AttributeError(name)
    answer = getattr(make(), name)
    if not callable(answer) or hasattr(answer, "dims"):
        return answer

    def call(*arguments: Any, **by_name: Any) -> Any:
        named = {key: _as_arrays(value) for key, value in by_name.items()}
        return answer(*map(_as_arrays, arguments), **named)

    return call
