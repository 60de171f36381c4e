// "Run" and "Debug" above scenarios.

const { CodeLens, Range, languages } = require("vscode");
const { findScenarios } = require("./scenarios");

const ACTIONS = [
  ["$(play) Run", "seoro.runScenario"],
  ["$(debug-alt) Debug", "seoro.debugScenario"],
];

class ScenarioLenses {
  provideCodeLenses(document) {
    return findScenarios(document.getText()).flatMap(({ name, line }) =>
      ACTIONS.map(([title, command]) => {
        const place = new Range(line, 0, line, 0);
        return new CodeLens(place, { title, command, arguments: [document.uri, name] });
      }),
    );
  }
}

function registerLenses(language) {
  return languages.registerCodeLensProvider({ scheme: "file", language }, new ScenarioLenses());
}

module.exports = { ScenarioLenses, registerLenses };
