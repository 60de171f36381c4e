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

export class DapConnection {
  private readonly socket: WebSocket;
  private readonly opened: Promise<void>;
  private readonly waiting = new Map<number, Waiting>();
  private count = 0;

  constructor(
    private readonly onEvent: (event: DapEvent) => void,
    onClose: () => void,
  ) {
    const address = new URL("/api/debug", location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(address);
    this.opened = new Promise((resolve, reject) => {
      this.socket.onopen = () => resolve();
      this.socket.onclose = () => {
        const error = new RequestFailed("the debugger has ended", "start the run again");
        reject(error);
        for (const each of this.waiting.values()) each.reject(error);
        this.waiting.clear();
        onClose();
      };
    });
    this.opened.catch(() => undefined); // the requests report it
    this.socket.onmessage = ({ data }: MessageEvent<string>) => this.take(JSON.parse(data) as { [name: string]: unknown });
  }

  async request(command: string, body: object): Promise<unknown> {
    await this.opened;
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

  close(): void {
    this.socket.close();
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
