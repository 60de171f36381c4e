// Messages of the Debug Adapter Protocol over a WebSocket.
import { RequestFailed } from "../net/api";

export interface DapEvent {
  event: string;
  body?: { [name: string]: unknown };
}

interface Waiting {
  resolve: (body: unknown) => void;
  reject: (error: Error) => void;
}

const LONGEST = 30_000; // [ms] to wait for an answer
const FINISHED = 1000; // close code after which the session has ended; it stays when the page is loaded again
const REPLACED = 4409; // another page debugs the run

/** Why a connection was closed. */
export type Closing = "ended" | "replaced" | "lost";

export class DapConnection {
  private readonly socket: WebSocket;
  private readonly opened: Promise<void>;
  private readonly waiting = new Map<number, Waiting>();
  private count = 0;

  /**
   * Connect to a new debug adapter, or to that of a run.
   *
   * @param run ID of an active run, or an empty text.
   */
  constructor(
    run: string,
    private readonly onEvent: (event: DapEvent) => void,
    onClose: (closing: Closing) => void,
  ) {
    const address = new URL(run === "" ? "/api/debug" : `/api/debug?run=${encodeURIComponent(run)}`, location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(address);
    this.opened = new Promise((resolve, reject) => {
      this.socket.onopen = () => resolve();
      this.socket.onclose = ({ code }) => {
        const closing = code === FINISHED ? "ended" : code === REPLACED ? "replaced" : "lost";
        const error =
          closing === "lost"
            ? new RequestFailed("the connection is lost", "try again when it is open")
            : new RequestFailed("the debugger has ended", "start the run again");
        reject(error);
        for (const each of this.waiting.values()) each.reject(error);
        this.waiting.clear();
        onClose(closing);
      };
    });
    this.opened.catch(() => undefined); // the requests report it
    this.socket.onmessage = ({ data }: MessageEvent<string>) => this.take(JSON.parse(data) as { [name: string]: unknown });
  }

  async request(command: string, body: object): Promise<unknown> {
    await this.opened;
    if (this.socket.readyState !== WebSocket.OPEN) throw new RequestFailed("the connection is lost");
    const seq = ++this.count;
    const answer = new Promise((resolve, reject) => this.waiting.set(seq, { resolve, reject }));
    this.socket.send(JSON.stringify({ seq, type: "request", command, arguments: body }));
    const timer = setTimeout(() => this.waiting.get(seq)?.reject(new RequestFailed(`no answer to ${command}`)), LONGEST);
    try {
      return await answer;
    } finally {
      clearTimeout(timer);
      this.waiting.delete(seq);
    }
  }

  /** End the session and its run. */
  close(): void {
    this.socket.close(FINISHED);
  }

  private take(message: { [name: string]: unknown }): void {
    if (message["type"] === "event") {
      this.onEvent(message as unknown as DapEvent);
    } else if (message["type"] === "response") {
      const waiting = this.waiting.get(Number(message["request_seq"]));
      if (message["success"]) waiting?.resolve(message["body"] ?? {});
      else waiting?.reject(new RequestFailed(String(message["message"] ?? "the debugger refused")));
    } else if (typeof message["error"] === "string") {
      const error = new RequestFailed(message["error"], String(message["help"] ?? ""), String(message["field"] ?? ""));
      for (const each of this.waiting.values()) each.reject(error);
    }
  }
}
