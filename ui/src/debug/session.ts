// A debugged run: the page is the client of `seoro dap`, which the server runs.
import { RequestFailed } from "../net/api";
import { Retry } from "../net/retry";
import { Cell } from "../state";
import { type Closing, DapConnection, type DapEvent } from "./connection";

export interface Breakpoint {
  file: string;
  line: number;
  condition: string;
  isVerified: boolean;
  message: string;
}

export interface Thread {
  id: number;
  name: string;
}

export interface StackFrame {
  id: number;
  name: string;
  line: number;
  source?: { name: string; path?: string };
}

/** A scope of variables, or a value with parts. */
export interface Variable {
  name: string;
  value: string;
  type?: string;
  variablesReference: number;
}

export type DebugStatus = "none" | "starting" | "running" | "paused" | "ended" | "replaced" | "lost";

export const STEPS = [
  ["next", "Step over", "F10"],
  ["stepIn", "Step into", "F11"],
  ["stepOut", "Step out", "Shift+F11"],
  ["record", "Next record", ""],
  ["instant", "Next instant", ""],
] as const;
export type StepName = (typeof STEPS)[number][0];

/** Breakpoints of a file, as the server keeps them. */
interface Placed {
  source: { name: string };
  breakpoints: { line: number; condition?: string; verified: boolean; message?: string }[];
}

const RUN = "seoro.debugged"; // key of the run in the storage of the tab

/** The only session of a page, which returns to it when it is loaded again, or its connection was lost. */
class DebugSession {
  readonly status = new Cell<DebugStatus>("none");
  /** ID of the run. */
  readonly run = new Cell("");
  /** Why the run is paused, or how it ended. */
  readonly text = new Cell("");
  readonly thread = new Cell(0);
  readonly breakpoints = new Cell<readonly Breakpoint[]>([]);
  readonly output = new Cell<readonly string[]>([]);
  /** Number of pauses so far: views of a pause read again when it changes. */
  readonly pauses = new Cell(0);
  private connection: DapConnection | null = null;
  private folder = "";
  private readonly retry = new Retry(() => this.connect(this.run.value));

  /** Start a run that is paused at its start. */
  async launch(settings: object): Promise<{ run: string }> {
    this.connection?.close();
    this.reset();
    sessionStorage.removeItem(RUN);
    const { file, scenario, simulator, world, rate, seed, set } = settings as Record<string, unknown>;
    const connection = this.connect("");
    try {
      await connection.request("initialize", { adapterID: "seoro", linesStartAt1: true, columnsStartAt1: true });
      const fields = { program: file, scenario, sim: simulator, world, rate: rate === "max" ? undefined : rate, seed, set };
      await connection.request("launch", { ...fields, stopOnEntry: true });
      await connection.request("configurationDone", {});
    } catch (error) {
      connection.close();
      this.status.value = "none";
      throw error;
    }
    if (this.run.value === "") throw new RequestFailed("the debugged run has no trace");
    return { run: this.run.value };
  }

  /** Return to the run that this tab debugged before it was loaded again; one that has ended is ignored. */
  async restore(): Promise<void> {
    const run = sessionStorage.getItem(RUN);
    if (run === null) return;
    this.reset();
    this.connect(run);
    await new Promise<void>((resolve) => {
      const stop = this.status.subscribe(() => {
        stop();
        resolve();
      });
    });
  }

  async resume(): Promise<void> {
    await this.move("continue", { threadId: this.thread.value });
  }

  async step(name: StepName): Promise<void> {
    const isNamed = name === "record" || name === "instant";
    await this.move(isNamed ? "seoro/step" : name, isNamed ? { to: name } : { threadId: this.thread.value });
  }

  async pause(): Promise<void> {
    await this.connection?.request("pause", { threadId: this.thread.value });
  }

  async stop(): Promise<void> {
    await this.connection?.request("terminate", {});
  }

  /** Add a breakpoint, or remove the one in the line. */
  async toggle(file: string, line: number): Promise<void> {
    const others = this.breakpoints.value.filter((each) => each.file !== file || each.line !== line);
    const isNew = others.length === this.breakpoints.value.length;
    const added = isNew ? [{ file, line, condition: "", isVerified: false, message: "" }] : [];
    await this.setBreakpoints(file, [...others, ...added]);
  }

  async setCondition(changed: Breakpoint, condition: string): Promise<void> {
    const found = this.breakpoints.value.map((each) => (each === changed ? { ...each, condition } : each));
    await this.setBreakpoints(changed.file, found);
  }

  async threads(): Promise<Thread[]> {
    return (await this.ask<{ threads: Thread[] }>("threads", {})).threads;
  }

  async stack(thread: number): Promise<StackFrame[]> {
    return (await this.ask<{ stackFrames: StackFrame[] }>("stackTrace", { threadId: thread })).stackFrames;
  }

  async scopes(frame: number): Promise<Variable[]> {
    const { scopes } = await this.ask<{ scopes: { name: string; variablesReference: number }[] }>("scopes", { frameId: frame });
    return scopes.map((scope) => ({ ...scope, value: "" }));
  }

  async variables(reference: number): Promise<Variable[]> {
    return (await this.ask<{ variables: Variable[] }>("variables", { variablesReference: reference })).variables;
  }

  async evaluate(expression: string, frame: number | null): Promise<string> {
    const found = await this.ask<{ result: string }>("evaluate", { expression, ...(frame === null ? {} : { frameId: frame }) });
    return found.result;
  }

  private async ask<T>(command: string, body: object): Promise<T> {
    if (this.connection === null) throw new RequestFailed("the run is not debugged");
    return (await this.connection.request(command, body)) as T;
  }

  private async move(command: string, body: object): Promise<void> {
    if (this.status.value !== "paused") return;
    this.status.value = "running";
    await this.ask(command, body);
  }

  private async setBreakpoints(file: string, all: readonly Breakpoint[]): Promise<void> {
    const own = all.filter((each) => each.file === file).sort((a, b) => a.line - b.line);
    const wanted = own.map(({ line, condition }) => ({ line, ...(condition === "" ? {} : { condition }) }));
    const body = { source: { name: file, path: this.pathOf(file) }, breakpoints: wanted };
    const found = await this.ask<{ breakpoints: { verified: boolean; line: number; message?: string }[] }>("setBreakpoints", body);
    const placed = own.map((each, index) => ({
      ...each,
      line: found.breakpoints[index]?.line ?? each.line,
      isVerified: found.breakpoints[index]?.verified ?? false,
      message: found.breakpoints[index]?.message ?? "",
    }));
    this.breakpoints.value = [...all.filter((each) => each.file !== file), ...placed];
  }

  private pathOf(file: string): string {
    return file.startsWith("/") || this.folder === "" ? file : `${this.folder.replace(/\/$/, "")}/${file}`;
  }

  private connect(run: string): DapConnection {
    const connection = new DapConnection(
      run,
      (event) => this.onEvent(event),
      (closing) => this.onClose(connection, closing),
    );
    this.connection = connection;
    return connection;
  }

  private reset(): void {
    this.retry.cancel();
    this.status.value = "starting";
    this.run.value = "";
    this.text.value = "";
    this.forgetState();
  }

  /** Forget what the server sends to a page that returns. */
  private forgetState(): void {
    this.retry.reset();
    this.breakpoints.value = [];
    this.output.value = [];
  }

  private onEvent({ event, body = {} }: DapEvent): void {
    if (event === "seoro/run") {
      if (this.status.value === "lost") this.forgetState();
      this.run.value = String(body["run"]);
      this.folder = String(body["cwd"] ?? "");
      sessionStorage.setItem(RUN, this.run.value);
      this.status.value = "running";
    } else if (event === "seoro/breakpoints") {
      this.restoreBreakpoints(body as unknown as Placed);
    } else if (event === "stopped") {
      this.thread.value = Number(body["threadId"] ?? 1);
      this.text.value = String(body["description"] ?? "Paused");
      this.status.value = "paused";
      this.pauses.value++;
    } else if (event === "output") {
      this.output.value = [...this.output.value.slice(-199), String(body["output"] ?? "").trimEnd()];
    } else if (event === "terminated") {
      this.end("ended", "The run has ended.");
    }
  }

  private restoreBreakpoints({ source, breakpoints }: Placed): void {
    const found = breakpoints.map(({ line, condition = "", verified, message = "" }) => {
      return { file: source.name, line, condition, isVerified: verified, message };
    });
    this.breakpoints.value = [...this.breakpoints.value.filter((each) => each.file !== source.name), ...found];
  }

  private onClose(connection: DapConnection, closing: Closing): void {
    if (this.connection !== connection || this.status.value === "none" || this.status.value === "ended") return;
    const hasRun = this.run.value !== "";
    if (hasRun && closing === "lost") {
      this.status.value = "lost";
      this.retry.schedule();
    } else {
      const wasLost = this.status.value === "lost";
      this.end(hasRun && closing !== "lost" ? closing : "none", `The run has ended${wasLost ? " while the connection was lost" : ""}.`);
    }
  }

  private end(status: "none" | "ended" | "replaced", text: string): void {
    sessionStorage.removeItem(RUN);
    this.text.value = text;
    this.status.value = status;
  }
}

export const debugSession = new DebugSession();
