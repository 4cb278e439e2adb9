"""Training is what PyTorch's own optimiser does, and trainings side by side are those one after the other."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import torch

from billow.rom.learn.network import SILU, TANH, OneCycleAdamW, _start, _step, train_shared
from billow.rom.learn.side_by_side import side_by_side

STEPS = 9


def gradients(parameters, step):
    generator = torch.Generator().manual_seed(step)
    for p in parameters:
        p.grad = torch.randn(p.shape, generator=generator) * 10.0 ** (step % 4 - 2)


@pytest.mark.parametrize("steps", [1, 2, 4, STEPS])
def test_the_optimiser_is_that_of_pytorch_with_one_cycle_to_the_bit(steps):
    start = [torch.randn(3, 4, 5, generator=torch.Generator().manual_seed(k)) for k in range(3)]
    one, other = ([p.clone().requires_grad_() for p in start] for _ in range(2))
    ours, theirs = OneCycleAdamW(one, steps), torch.optim.AdamW(other, lr=6e-3, weight_decay=1e-2, fused=True)
    schedule = torch.optim.lr_scheduler.OneCycleLR(theirs, max_lr=6e-3, total_steps=steps)
    for step in range(steps):
        gradients(one, step)
        gradients(other, step)
        ours.step()
        theirs.step()
        schedule.step()
        for a, b in zip(one, other, strict=True):
            assert torch.equal(a, b)
    assert not torch.equal(one[0], start[0])


@pytest.mark.parametrize(("ours", "theirs"), [(SILU, torch.nn.functional.silu), (TANH, torch.tanh)])
def test_gradients_are_those_of_pytorch_to_the_bit(ours, theirs):
    generator = torch.Generator().manual_seed(1)
    weights, biases = _start(2, (4, 7, 5, 3), generator)
    x, y = torch.randn(2, 11, 4, generator=generator), torch.randn(2, 11, 3, generator=generator)

    class Nothing:
        def step(self):
            pass

    loss = _step(weights, biases, ours, Nothing(), x, y)
    told = [p.grad for p in weights + biases]
    hidden = x
    for weight, bias in zip(weights[:-1], biases[:-1], strict=True):
        hidden = theirs(torch.baddbmm(bias, hidden, weight))
    errors = (torch.baddbmm(biases[-1], hidden, weights[-1]) - y).square().mean(dim=(1, 2))
    expected = torch.autograd.grad(errors.sum(), weights + biases)
    assert loss == float(errors.detach().mean())
    assert all(torch.equal(a, b) for a, b in zip(told, expected, strict=True))


def samples(seed):
    random = np.random.default_rng(seed)
    return random.normal(size=(70, 3)).astype(np.float32), random.normal(size=(70, 2)).astype(np.float32)


def trained(seed):
    return lambda report: train_shared(*samples(seed), epochs=3, seed=seed, progress=report)


def test_side_by_side_is_one_after_the_other(monkeypatch):
    monkeypatch.setattr("billow.rom.learn.side_by_side.available_cores", lambda: 3)
    told = []
    found = list(side_by_side(map(trained, range(4)), 1, 5, lambda *said: told.append(said)))
    for seed, (weights, _) in enumerate(found):
        alone, _ = trained(seed)(None)
        assert all(np.array_equal(a, b) for a, b in zip(weights, alone, strict=True))
    assert [epoch for epoch, *_ in told] == list(range(4, 16))  # after the three of the training before
    assert {(of, which) for _, of, _, which in told} == {(15, f"training {k} of 5") for k in range(2, 6)}


def test_whoever_fails_stops_the_others(monkeypatch):
    monkeypatch.setattr("billow.rom.learn.side_by_side.available_cores", lambda: 2)
    begun, epochs = threading.Event(), []

    def fails(report):
        begun.wait(10.0)
        raise ValueError("no")

    def goes_on(report):
        for epoch in range(10**6):
            begun.set()
            epochs.append(epoch)
            report(epoch, 10**6, 0.0)

    with pytest.raises(ValueError, match="no"):
        list(side_by_side([fails, goes_on], 0, 2, None))
    assert len(epochs) < 10**6
    assert threading.active_count() < 10
