// A run of a server: frames by a WebSocket, blocks of records by requests.
import { bytes } from "../net/api";
import { LiveSocket } from "../net/socket";
import { Cell } from "../state";
import { type BlockSource, FramePieces } from "./frames";
import { RunModel } from "./model";
import { inflate } from "./unpack";

const HIDDEN = 1_000; // [ms] between frames for a hidden page

/** A run that is followed while its page is open. */
export class ServedRun {
  /** The run; null until its first frame. A new one replaces it if the connection was lost. */
  readonly model = new Cell<RunModel | null>(null);
  readonly socket: LiveSocket;

  constructor(readonly id: string) {
    const path = `/api/run/${encodeURIComponent(id)}`;
    const source = blocksOf(path);
    const pieces = new FramePieces();
    const take = (data: string | ArrayBuffer) => {
      if (typeof data === "string") return;
      const frame = pieces.add(data);
      if (frame === null) {
        this.socket.send("next");
        return;
      }
      // The server sends the next frame while the page draws this one: a busy page gets fewer and larger frames.
      whenDrawn(() => this.socket.send("next"));
      if (this.model.value === null || frame.meta.first) this.model.value = new RunModel(frame, source, true);
      else this.model.value.append(frame);
    };
    this.socket = new LiveSocket(path, take, () => pieces.clear());
  }

  close(): void {
    this.socket.close();
  }
}

/** Call a function when the page draws next; later if it is hidden, and draws nothing. */
function whenDrawn(call: () => void): void {
  const timer = setTimeout(done, HIDDEN);
  const frame = requestAnimationFrame(done);
  function done() {
    clearTimeout(timer);
    cancelAnimationFrame(frame);
    call();
  }
}

function blocksOf(path: string): BlockSource {
  return {
    block: async (number) => {
      for (let pause = 500; ; pause = Math.min(2 * pause, 5_000)) {
        const found = await bytes(`${path}/block/${number}`).catch(() => null);
        if (found !== null) return new TextDecoder().decode(await inflate(found));
        await new Promise((resume) => setTimeout(resume, pause)); // the connection is lost, or the run was deleted
      }
    },
  };
}
