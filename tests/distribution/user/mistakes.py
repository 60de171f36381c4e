"""Wrong uses of the public interface: each line with the comment has an error."""

from __future__ import annotations

import seoro
import seoro.campaign as sc
from seoro import ActionContext, Actor


@seoro.action("lamp.blink")
async def blink(ctx: ActionContext, lamp: Actor, count: int) -> None:
    ctx.sleep(1.0)  # wrong: not awaited
    await ctx.sleep("1s")  # wrong
    ctx.log(count)  # wrong
    lamp.name = 3  # wrong


def script() -> None:
    scenario = seoro.load(3)  # wrong
    seoro.load("maze.osc", strict=True)  # wrong
    verdict = seoro.run(scenario, seeed=7)  # wrong
    seoro.run(scenario, clock=3)  # wrong
    seoro.run("maze.osc")  # wrong
    seoro.run(scenario, simulator="mujoco")  # wrong
    print(verdict.sucess)  # wrong
    if verdict.status == seoro.RunStatus.PASED:  # wrong
        print(seoro.Verdikt)  # wrong


async def client() -> None:
    async with seoro.Client() as connected:
        run = await connected.submit("lab-a")  # wrong
        verdict = run.result()
        print(verdict.passed)  # wrong: not awaited


def campaign() -> None:
    results = sc.run("load.osc", strategy="uniform", runs=10)  # wrong
    sc.run("load.osc", strategy=sc.Uniform(), runs="10")  # wrong
    print(results.rate().percent)  # wrong
