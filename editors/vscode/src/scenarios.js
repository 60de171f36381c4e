// Finds the scenarios of a text, without a parser: they begin at the left margin.

const SCENARIO = /^scenario\s+([A-Za-z_][\w.]*)/;

/**
 * @param {string} text Text of a scenario file.
 * @returns {{name: string, line: number}[]} Scenarios in order, with their lines from 0.
 */
function findScenarios(text) {
  const found = [];
  for (const [line, content] of text.split(/\r\n|\r|\n/).entries()) {
    const name = SCENARIO.exec(content)?.[1];
    if (name !== undefined) {
      found.push({ name, line });
    }
  }
  return found;
}

module.exports = { findScenarios };
