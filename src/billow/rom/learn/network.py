"""Training of the networks: the only file that uses PyTorch.

Networks of equal shape are trained side by side as one batched product. Their losses are added, so this equals training
them one after the other. One thread: the products are too small to gain from more, and bits depend on the seed alone.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
import torch
from torch.optim.adamw import adamw

from billow.base.errors import NumericalStop
from billow.rom.learn.progress import Progress

DIVERGED = NumericalStop.declare(
    "E-ROM-014",
    "training diverged: the loss is {loss}",
    where="epoch {epoch} of {epochs}",
    why="the optimiser left the region where the networks are smooth",
    cause="outliers among the runs",
    remedy="train with another seed; look at the runs for outliers",
)

MEMBERS = 3
HIDDEN_SHARED = (96, 96, 96, 96)
BATCH_SHARED = 64
EPOCHS_SHARED = (30, 200)
STEPS_SHARED = 20_000
"""As many epochs as `STEPS_SHARED` steps of the optimiser are, within `EPOCHS_SHARED`: 200 up to 128 runs of 50 times,
64 for 400. What was compared: docs/rom.md, "Why the default recipe looks as it does"."""

HIDDEN_PAPER = (25, 45, 15)
RATE_PAPER = 3e-4
EPOCHS_PAPER = 15_000


@contextmanager
def one_thread():
    """PyTorch computes with one thread, in this thread and in those that begin within."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def epochs_for(samples: int) -> int:
    """Epochs of `train_shared` by default."""
    fewest, most = EPOCHS_SHARED
    return max(fewest, min(most, round(STEPS_SHARED / math.ceil(samples / BATCH_SHARED))))


@one_thread()
def train_shared(inputs, targets, *, epochs: int | None = None, seed: int = 0, progress: Progress | None = None):
    """An ensemble of networks, each with all coefficients as outputs.

    inputs: [-], (samples, width) float32; targets: standardised, [-], (samples, outputs) float32
    Returns weights and biases as `Regression` takes them, with `MEMBERS` networks.
    SiLU, AdamW with weight decay 1e-2, one-cycle rate up to 6e-3, every member with its own start and batch order.
    Raises NumericalStop E-ROM-014 if the loss stops being finite.
    """
    batches = math.ceil(len(inputs) / BATCH_SHARED)
    epochs = epochs or epochs_for(len(inputs))
    generator = torch.Generator().manual_seed(seed)
    x, y = torch.from_numpy(inputs), torch.from_numpy(targets)
    weights, biases = _start(MEMBERS, (inputs.shape[1], *HIDDEN_SHARED, targets.shape[1]), generator)
    optimiser = OneCycleAdamW(weights + biases, epochs * batches)
    for epoch in range(1, epochs + 1):
        order = torch.stack([torch.randperm(len(x), generator=generator) for _ in range(MEMBERS)])
        losses = []
        for chosen in order.tensor_split(batches, dim=1):
            losses.append(_step(weights, biases, SILU, optimiser, x[chosen], y[chosen]))
        _tell(progress, epoch, epochs, sum(losses) / len(losses))
    return _arrays(weights), _arrays(biases)


@one_thread()
def train_paper(
    inputs, targets, *, epochs=None, seed=0, progress=None, hidden=HIDDEN_PAPER, rate=RATE_PAPER, checkpoint=None
):
    """The ROM paper's own recipe: one network [7, 25, 45, 15, 1] per mode and component.

    Arguments and errors as `train_shared`; returns one network per output. Adam with rate 3e-4, all samples in one
    batch, 15,000 epochs. The paper names neither activation nor output scaling; tanh and standardised outputs here.

    hidden, rate: neurons and learning rate, those of the paper's first test case by default
    checkpoint: where training saves its state and resumes, with the same bits as without interruption: due() says
        whether it is time to save, save(epoch, arrays) keeps a state, load() gives the last or (0, {})
    """
    epochs, outputs = epochs or EPOCHS_PAPER, targets.shape[1]
    x = torch.from_numpy(inputs).expand(outputs, -1, -1)
    y = torch.from_numpy(np.ascontiguousarray(targets.T))[:, :, None]
    generator = torch.Generator().manual_seed(seed)
    weights, biases = _start(outputs, (inputs.shape[1], *hidden, 1), generator)
    optimiser = torch.optim.Adam(weights + biases, lr=rate, fused=True)
    done = 0 if checkpoint is None else _restore(checkpoint, weights + biases, optimiser)
    for epoch in range(done + 1, epochs + 1):
        loss = _step(weights, biases, TANH, optimiser, x, y)
        if math.isfinite(loss) and checkpoint is not None and (checkpoint.due() or epoch == epochs):
            checkpoint.save(epoch, _state(weights + biases, optimiser))
        _tell(progress, epoch, epochs, loss)
    return _arrays(weights), _arrays(biases)


class Activation(NamedTuple):
    """value: of a sum. slope: the gradient by the sum, from that by the value, the sum and the value."""

    value: Callable[[torch.Tensor], torch.Tensor]
    slope: Callable[[torch.Tensor, torch.Tensor, torch.Tensor], torch.Tensor]


SILU = Activation(torch.nn.functional.silu, lambda by, of, value: torch.ops.aten.silu_backward(by, of))
TANH = Activation(torch.tanh, lambda by, of, value: torch.ops.aten.tanh_backward(by, value))


class OneCycleAdamW:
    """`torch.optim.AdamW` with the rates of `OneCycleLR`, to the bit, and without what these do besides, which takes a
    seventh of a step, and 2 s when the first one is made.

    Rate and momentum go from a 25th of RATE and SLOWEST to RATE and FASTEST in the first WARM_UP of all steps, and on
    to next to nothing and SLOWEST, along half a cosine each (Smith and Topin, arXiv 1708.07120).
    """

    RATE, DECAY, WARM_UP = 6e-3, 1e-2, 0.3
    SLOWEST, FASTEST = 0.95, 0.85
    """Momentum: of the past in the mean gradient."""

    def __init__(self, parameters: list[torch.Tensor], steps: int):
        self._parameters, self._steps, self._done = parameters, steps, 0
        self._means, self._squares = ([torch.zeros_like(p) for p in parameters] for _ in range(2))
        self._counts = [torch.zeros(()) for _ in parameters]

    @torch.no_grad()
    def step(self) -> None:
        top, end = self.WARM_UP * self._steps - 1.0, self._steps - 1.0
        if self._done <= top:
            share, rates, momenta = self._done / top, (self.RATE / 25.0, self.RATE), (self.SLOWEST, self.FASTEST)
        else:
            share, rates = (self._done - top) / (end - top), (self.RATE, self.RATE / 25.0 / 1e4)
            momenta = self.FASTEST, self.SLOWEST
        rate, momentum = (b + (a - b) / 2.0 * (math.cos(math.pi * share) + 1.0) for a, b in (rates, momenta))
        adamw(
            self._parameters, [p.grad for p in self._parameters], self._means, self._squares, [], self._counts,
            fused=True, amsgrad=False, beta1=momentum, beta2=0.999, lr=rate, weight_decay=self.DECAY, eps=1e-8,
            maximize=False,
        )  # fmt: skip
        self._done += 1


@torch.no_grad()
def _step(weights, biases, activation: Activation, optimiser, x, y) -> float:
    """One step of the optimiser; returns the mean loss of the networks before it.

    Gradients have the bits of `backward()`, and take a fifth less of a step than with its records of what was computed.
    """
    inputs, sums = [x], []
    for weight, bias in zip(weights[:-1], biases[:-1], strict=True):
        sums.append(torch.baddbmm(bias, inputs[-1], weight))
        inputs.append(activation.value(sums[-1]))
    errors = torch.baddbmm(biases[-1], inputs[-1], weights[-1]) - y
    losses = errors.square().mean(dim=(1, 2))
    slope = errors * (2.0 / (errors.shape[1] * errors.shape[2]))
    for layer in range(len(weights) - 1, -1, -1):
        weights[layer].grad = torch.bmm(inputs[layer].transpose(1, 2), slope)
        biases[layer].grad = slope.sum(dim=1, keepdim=True)
        if layer > 0:
            slope = torch.bmm(slope, weights[layer].transpose(1, 2))
            slope = activation.slope(slope, sums[layer - 1], inputs[layer])
    optimiser.step()
    return float(losses.mean())


def _tell(progress: Progress | None, epoch: int, epochs: int, loss: float) -> None:
    """Report an epoch. NumericalStop E-ROM-014 if its loss is not finite."""
    if not math.isfinite(loss):
        raise DIVERGED(loss=loss, epoch=epoch, epochs=epochs)
    if progress is not None:
        progress(epoch, epochs, loss)


def _state(parameters, optimiser) -> dict[str, np.ndarray]:
    """Everything a full-batch training with Adam consists of; there are no random batches."""
    arrays = {}
    for number, parameter in enumerate(parameters):
        arrays[f"value.{number}"] = parameter.detach().numpy().copy()
        for moment in ("exp_avg", "exp_avg_sq"):
            arrays[f"{moment}.{number}"] = optimiser.state[parameter][moment].numpy().copy()
    return arrays


def _restore(checkpoint, parameters, optimiser) -> int:
    """Bring parameters and optimiser to where a checkpoint left them; returns the epochs done."""
    epoch, arrays = checkpoint.load()
    for number, parameter in enumerate(parameters if epoch else ()):
        with torch.no_grad():
            parameter.copy_(torch.from_numpy(arrays[f"value.{number}"]))
        moments = {name: torch.from_numpy(arrays[f"{name}.{number}"]) for name in ("exp_avg", "exp_avg_sq")}
        optimiser.state[parameter] = {"step": torch.tensor(float(epoch)), **moments}
    return epoch


def _start(networks, sizes, generator):
    """Uniform in +-1/sqrt(inputs), the start PyTorch itself gives linear layers."""
    weights, biases = [], []
    for inputs, outputs in itertools.pairwise(sizes):
        bound = 1.0 / math.sqrt(inputs)
        for values, rows in ((weights, inputs), (biases, 1)):
            drawn = torch.rand((networks, rows, outputs), generator=generator)
            values.append((drawn * (2.0 * bound) - bound).requires_grad_())
    return weights, biases


def _arrays(tensors) -> tuple[np.ndarray, ...]:
    return tuple(tensor.detach().numpy().copy() for tensor in tensors)
