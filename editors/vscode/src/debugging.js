// Debugging of scenarios by `seoro dap`.

const { DebugAdapterExecutable, commands, debug, window } = require("vscode");
const { commandLine } = require("./command");

const TYPE = "seoro";

/** The configuration of a scenario; settings of `seoro.run.arguments` that a run needs are left to `launch.json`. */
function configurationOf(file, scenario) {
  return { type: TYPE, request: "launch", name: scenario ?? "scenario", program: file, ...(scenario && { scenario }) };
}

const factory = {
  createDebugAdapterDescriptor() {
    const [program, args] = commandLine("dap");
    return new DebugAdapterExecutable(program, args);
  },
};

const provider = {
  /** Complete an empty configuration, as of F5 without a `launch.json`, by the open file. */
  resolveDebugConfiguration(folder, configuration) {
    if (configuration.program !== undefined) {
      return configuration;
    }
    const document = window.activeTextEditor?.document;
    if (document?.languageId !== "osc") {
      window.showErrorMessage("seoro: open a scenario file, or set `program` in launch.json");
      return undefined;
    }
    return { ...configurationOf(document.uri.fsPath), ...configuration };
  },
};

async function step(to) {
  const session = debug.activeDebugSession;
  if (session?.type !== TYPE) {
    window.showErrorMessage("seoro: no scenario is being debugged");
    return;
  }
  try {
    await session.customRequest("seoro/step", { to });
  } catch (error) {
    window.showErrorMessage(`seoro: ${error.message}`);
  }
}

function registerDebugging() {
  return [
    debug.registerDebugAdapterDescriptorFactory(TYPE, factory),
    debug.registerDebugConfigurationProvider(TYPE, provider),
    commands.registerCommand("seoro.stepToRecord", () => step("record")),
    commands.registerCommand("seoro.stepToInstant", () => step("instant")),
    commands.registerCommand("seoro.debugScenario", (uri, scenario) =>
      debug.startDebugging(undefined, configurationOf(uri.fsPath, scenario)),
    ),
  ];
}

module.exports = { configurationOf, provider, registerDebugging };
