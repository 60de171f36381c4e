// Start of the pages of `seoro ui`.
import { render } from "preact";
import { Problem } from "./app/Confirm";
import { Pages } from "./app/Pages";
import { LabStore, RunStore } from "./app/stores";
import type { Site } from "./app/types";
import { debugSession } from "./debug/session";
import { get } from "./net/api";
import { loadSpaceFrom } from "./space/loading";
import "./style/base.css";
import "./style/views.css";
import "./style/app.css";
import "./style/pages.css";

loadSpaceFrom("/static/world3d.js");

async function start(root: HTMLElement): Promise<void> {
  try {
    const [site] = await Promise.all([get<Site>("/api/site"), debugSession.restore()]);
    render(<Pages shared={{ site, runs: new RunStore(), lab: new LabStore() }} />, root);
    document.documentElement.dataset["ready"] = "true";
  } catch (error) {
    render(
      <main id="content">
        <h1>seoro</h1>
        <Problem error={error} />
      </main>,
      root,
    );
    document.documentElement.dataset["ready"] = "broken";
  }
}

const root = document.getElementById("app");
if (root !== null) void start(root);
