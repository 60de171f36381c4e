// What a paused run does: its branches with their frames, and the variables of a frame.
import { debugSession, type StackFrame, type Variable } from "./session";

const MOST_BRANCHES = 50;

export interface Branch {
  id: number;
  name: string;
  frames: StackFrame[];
  /** What it waits for, or does; empty if unknown. */
  activity: string;
}

export interface Group {
  name: string;
  variables: Variable[];
}

/** Read the branches of a pause, the paused one first. */
export async function readBranches(): Promise<Branch[]> {
  const paused = debugSession.thread.value;
  const threads = (await debugSession.threads()).sort((a, b) => Number(b.id === paused) - Number(a.id === paused));
  const found: Branch[] = [];
  for (const { id, name } of threads.slice(0, MOST_BRANCHES)) {
    found.push({ id, name, frames: await debugSession.stack(id), activity: "" });
  }
  const frame = found[0]?.frames[0];
  if (frame === undefined) return found;
  const activities = (await readGroups(frame.id)).find((group) => group.name === "Activity")?.variables ?? [];
  const texts = new Map(activities.map((each) => [each.name, each.value]));
  return found.map((branch) => ({ ...branch, activity: texts.get(branch.name) ?? "" }));
}

/** Read the variables that a frame sees, by groups. */
export async function readGroups(frame: number): Promise<Group[]> {
  const found: Group[] = [];
  for (const scope of await debugSession.scopes(frame)) {
    found.push({ name: scope.name, variables: await debugSession.variables(scope.variablesReference) });
  }
  return found;
}
