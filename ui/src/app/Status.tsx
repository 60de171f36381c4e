// State as sign and word.
import { signOf, wordOf } from "./words";

export function StatusBadge({ status }: { status: string }) {
  return (
    <span class={`status ${status}`}>
      <span class="sign" aria-hidden="true">
        {signOf(status)}
      </span>
      {wordOf(status)}
    </span>
  );
}
