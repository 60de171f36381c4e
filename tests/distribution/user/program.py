"""A program of a user with the public interface of seoro, for type checkers."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from pathlib import Path

import seoro
import seoro.campaign as sc
from seoro import (
    ActionContext,
    ActionFailed,
    Actor,
    Child,
    MethodContext,
    ModifierContext,
    Outcome,
    Status,
    ThreadContext,
)


@dataclass
class Bed:
    plant: str
    centre: seoro.Position3D
    soil: list[str]


@seoro.action("gardener.water")
async def water(ctx: ActionContext, gardener: Actor, where: Bed, amount: float) -> None:
    await ctx.sleep(2.0)
    if where.plant == "cactus":
        raise ActionFailed("it has had enough")
    ctx.log(f"{gardener.name} gives {amount:g} l at {where.centre.x:g} m")


@seoro.action("lamp.burn_in", thread=True)
def burn_in(ctx: ThreadContext, lamp: Actor) -> None:
    ctx.check_cancelled()
    ctx.log(f"{lamp.name} is on")


@seoro.modifier("patiently")
async def patiently(ctx: ModifierContext, child: Child, duration: float) -> Outcome:
    outcome = await child.run(limit=duration)
    return outcome or Outcome(Status.FAILED, f"it took longer than {duration:g} s")


def name_of(ctx: MethodContext, part: str) -> str:
    return f"{ctx.file.stem}-{part}-{ctx.seed}"


def once(path: Path) -> tuple[bool, float]:
    scenario: seoro.Scenario = seoro.load(path)
    verdict = seoro.run(scenario, seed=7, clock="virtual", overrides={"pause": "1.5s", "count": 2})
    if verdict.status is seoro.RunStatus.FAILED:
        print(verdict.reason)
    return verdict.passed, verdict.duration


async def in_a_loop() -> seoro.Verdict:
    simulator = seoro.Simulator(name="mujoco")
    async with seoro.start(seoro.load("patrol.osc"), simulator=simulator, external=["ready"]) as run:
        async with run.subscribe("robot.arrived") as arrivals:
            async for arrival in arrivals:
                await run.emit("ready", time=arrival.time)
        async for record in run.trace():
            print(record["kind"])
    return await run.result()


async def at_an_executor() -> seoro.Verdict:
    async with seoro.Client() as client:
        run = await client.submit("lab-a", "maze.osc", seed=7)
        async for record in run.records():
            print(record["t"])
        verdict = await run.result()
        await run.fetch("out")
    return verdict


async def campaign() -> list[str]:
    failed: list[str] = []
    async with sc.start("load.osc", strategy=sc.Uniform(), until=["5 failures"], seed=1, folder="out") as running:
        async for row in running.runs():
            if row.status is sc.End.FAILED:
                failed.append(row.reason or "")
    results = sc.run("load.osc", strategy=sc.Boundary(), runs=200, clock="virtual", folder="more")
    print(results.rate(), [row.values["load"] for row in results.rows()])
    return failed


def pass_rate(folder: Path) -> float:
    return sc.read(folder).rate().share or 0.0


if __name__ == "__main__":
    try:
        print(once(Path("patrol.osc")), asyncio.run(in_a_loop()).passed, asyncio.run(at_an_executor()).passed)
    except seoro.InvalidScenario as error:
        print(*error.diagnostics, sep="\n")
    except seoro.SeoroError as error:
        print(error)
