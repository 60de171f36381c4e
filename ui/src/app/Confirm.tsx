// Questions before something happens that cannot be undone.
import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { textOf } from "../net/api";

interface Props {
  title: string;
  children?: ComponentChildren;
  /** Text of the button that does it. */
  action: string;
  /** Label of a text to enter, such as a reason; none without. */
  ask?: string;
  /** Whether the text may be empty. */
  isOptional?: boolean;
  isDangerous?: boolean;
  onConfirm: (text: string) => Promise<void>;
  onClose: () => void;
}

/** A dialog that does something when it is confirmed; errors are shown in it. */
export function Confirm({ title, children, action, ask, isOptional, isDangerous, onConfirm, onClose }: Props) {
  const dialog = useRef<HTMLDialogElement>(null);
  const [text, setText] = useState("");
  const [isBusy, setIsBusy] = useState(false);
  const [problem, setProblem] = useState<unknown>(null);
  useEffect(() => {
    const element = dialog.current!;
    const before = document.activeElement;
    element.showModal();
    return () => {
      element.close();
      if (before instanceof HTMLElement) before.focus();
    };
  }, []);
  const isMissing = ask !== undefined && !isOptional && text.trim() === "";
  const confirm = async (event: Event) => {
    event.preventDefault();
    if (isMissing || isBusy) return;
    setIsBusy(true);
    setProblem(null);
    try {
      await onConfirm(text.trim());
      onClose();
    } catch (error) {
      setProblem(error);
      setIsBusy(false);
    }
  };
  return (
    <dialog
      ref={dialog}
      aria-labelledby="confirm-title"
      onCancel={(event) => {
        event.preventDefault();
        onClose();
      }}
    >
      <form onSubmit={(event) => void confirm(event)}>
        <h2 id="confirm-title">{title}</h2>
        {children}
        {ask !== undefined && (
          <label class="field">
            <span class="name">{isOptional ? `${ask} (optional)` : ask}</span>
            <input autofocus maxLength={300} value={text} onInput={(event) => setText(event.currentTarget.value)} />
          </label>
        )}
        {problem !== null && <Problem error={problem} />}
        <div class="actions">
          <button type="button" onClick={onClose}>
            Cancel
          </button>
          <button type="submit" class={isDangerous ? "danger" : "primary"} disabled={isBusy || isMissing}>
            {action}
          </button>
        </div>
      </form>
    </dialog>
  );
}

/** An error with its suggestion. */
export function Problem({ error }: { error: unknown }) {
  const found = textOf(error);
  return (
    <p class="problem" role="alert">
      <span class="sign" aria-hidden="true">
        !
      </span>
      <span>
        {found.error}
        {found.help && <span class="help"> {found.help}</span>}
      </span>
    </p>
  );
}
