// Live pictures of the cameras of a run's simulator.
import { useEffect, useMemo, useState } from "preact/hooks";
import { Problem } from "../app/Confirm";
import { useAnswer } from "../app/hooks";
import { get } from "../net/api";
import { LiveSocket } from "../net/socket";
import { Cell, useCell } from "../state";
import { clip, plain } from "../text";

interface Found {
  cameras: { name: string }[];
  problem: string;
}

/** Cameras are asked for only when the reader opens them. */
export function Cameras({ id, isActive }: { id: string; isActive: boolean }) {
  const [isOpen, setIsOpen] = useState(false);
  if (!isActive) return null;
  return (
    <details class="panel cameras" onToggle={(event) => setIsOpen(event.currentTarget.open)}>
      <summary>Cameras</summary>
      {isOpen && <Choice id={id} />}
    </details>
  );
}

function Choice({ id }: { id: string }) {
  const path = `/api/run/${encodeURIComponent(id)}`;
  const { data, error } = useAnswer(() => get<Found>(`${path}/cameras`), [path]);
  const [chosen, setChosen] = useState("");
  if (error) return <Problem error={error} />;
  if (data === null) return <p class="empty">Reading…</p>;
  if (data.cameras.length === 0) return <p class="empty">{plain(data.problem) || "The simulator of this run has no cameras."}</p>;
  const name = chosen || data.cameras[0]!.name;
  return (
    <>
      <label>
        <span class="name">camera</span>{" "}
        <select value={name} onChange={(event) => setChosen(event.currentTarget.value)}>
          {data.cameras.map((camera) => (
            <option key={camera.name} value={camera.name}>
              {clip(plain(camera.name), 80)}
            </option>
          ))}
        </select>
      </label>
      <Picture key={name} path={`${path}/camera?name=${encodeURIComponent(name)}`} name={name} />
    </>
  );
}

function Picture({ path, name }: { path: string; name: string }) {
  const address = useMemo(() => new Cell(""), []);
  const socket = useMemo(
    () =>
      new LiveSocket(path, (data) => {
        if (typeof data === "string") return;
        const before = address.value;
        address.value = URL.createObjectURL(new Blob([data], { type: "image/png" }));
        if (before) URL.revokeObjectURL(before);
      }),
    [path],
  );
  useEffect(
    () => () => {
      socket.close();
      URL.revokeObjectURL(address.value);
    },
    [socket],
  );
  const source = useCell(address);
  const refusal = useCell(socket.refusal);
  if (refusal) return <Problem error={new Error(refusal.error)} />;
  if (source === "") return <p class="empty">Waiting for the first picture…</p>;
  return <img class="camera" src={source} alt={`Live picture of the camera ${clip(plain(name), 80)}`} />;
}
