// Start of a report: read the data of the page, then show it.
import { render } from "preact";
import { RunModel } from "./data/model";
import { PageState } from "./state";
import { App } from "./views/App";
import "./style/base.css";
import "./style/views.css";

async function start(root: HTMLElement): Promise<void> {
  const fallback = [...root.childNodes];
  try {
    const run = await RunModel.embedded();
    const state = new PageState(run.meta.end?.explanation?.t ?? run.end);
    if (run.meta.end?.source) state.place.value = run.meta.end.source;
    if (!run.meta.sources.some((source) => source.text)) state.tab.value = "Log";
    root.replaceChildren();
    render(<App run={run} state={state} />, root);
    document.documentElement.dataset["ready"] = "true";
  } catch (error) {
    const message = document.createElement("p");
    message.className = "broken";
    message.setAttribute("role", "alert");
    message.textContent = `This report cannot be shown in full: ${error instanceof Error ? error.message : String(error)}`;
    root.replaceChildren(message, ...fallback);
    document.documentElement.dataset["ready"] = "broken";
  }
}

const root = document.getElementById("app");
if (root !== null) void start(root);
