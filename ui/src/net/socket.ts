// WebSockets that are opened again when the connection is lost.
import { Cell } from "../state";
import { Retry } from "./retry";

export type SocketState = "connecting" | "open" | "lost" | "refused";

/** Error that the server sent instead of data. */
export interface Refusal {
  error: string;
  help?: string;
}

/** A connection that lasts as long as its page. */
export class LiveSocket {
  readonly state = new Cell<SocketState>("connecting");
  /** Why the server refused; it is not asked again. */
  readonly refusal = new Cell<Refusal | null>(null);
  private socket: WebSocket | null = null;
  private readonly retry = new Retry(() => this.open());
  private isClosed = false;

  /**
   * @param path Path on the server.
   * @param onMessage Called with each message: a text or bytes.
   * @param onOpen Called for each new connection.
   */
  constructor(
    private readonly path: string,
    private readonly onMessage: (data: string | ArrayBuffer) => void,
    private readonly onOpen: () => void = () => undefined,
  ) {
    this.open();
  }

  send(data: string): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(data);
  }

  close(): void {
    this.isClosed = true;
    this.retry.cancel();
    this.socket?.close();
  }

  private open(): void {
    const address = new URL(this.path, location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      this.retry.reset();
      this.state.value = "open";
      this.onOpen();
    };
    socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => {
      const refusal = typeof data === "string" ? refusalIn(data) : null;
      if (refusal === null) this.onMessage(data);
      else this.refuse(refusal);
    };
    socket.onclose = () => {
      if (this.isClosed || this.socket !== socket || this.state.value === "refused") return;
      this.state.value = "lost";
      this.retry.schedule();
    };
  }

  private refuse(refusal: Refusal): void {
    this.refusal.value = refusal;
    this.state.value = "refused";
    this.socket?.close();
  }
}

function refusalIn(text: string): Refusal | null {
  if (!text.startsWith('{"error"')) return null;
  const found = JSON.parse(text) as Refusal;
  return typeof found.error === "string" ? found : null;
}
