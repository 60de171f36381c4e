// Attempts to open a lost connection again, with growing pauses, and at once when the machine is online again.
const FIRST_PAUSE = 250; // [ms] before the first attempt
const LONGEST_PAUSE = 4_000; // [ms]

export class Retry {
  private pause = FIRST_PAUSE;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly attempt: () => void) {}

  /** Make an attempt after a pause; the next pause is longer. */
  schedule(): void {
    this.cancel();
    this.timer = setTimeout(this.now, this.pause * (0.8 + 0.4 * Math.random()));
    this.pause = Math.min(2 * this.pause, LONGEST_PAUSE);
    addEventListener("online", this.now);
  }

  /** Begin with short pauses again, since the connection is open. */
  reset(): void {
    this.pause = FIRST_PAUSE;
  }

  /** Make no further attempt. */
  cancel(): void {
    clearTimeout(this.timer);
    removeEventListener("online", this.now);
  }

  private readonly now = () => {
    this.cancel();
    this.attempt();
  };
}
