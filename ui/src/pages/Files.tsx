// Files of a run, to download.
import { useState } from "preact/hooks";
import { Problem } from "../app/Confirm";
import { useAnswer } from "../app/hooks";
import { get } from "../net/api";
import { clip, digits, plain, plural } from "../text";

interface FileEntry {
  name: string;
  size: number;
}

export function Files({ id, isActive }: { id: string; isActive: boolean }) {
  const [isOpen, setIsOpen] = useState(false);
  return (
    <details class="panel" onToggle={(event) => setIsOpen(event.currentTarget.open)}>
      <summary>Files</summary>
      {isOpen && <List id={id} isActive={isActive} />}
    </details>
  );
}

function List({ id, isActive }: { id: string; isActive: boolean }) {
  const path = `/api/run/${encodeURIComponent(id)}/files`;
  const { data, error } = useAnswer(() => get<{ files: FileEntry[] }>(path), [path, isActive]);
  if (error) return <Problem error={error} />;
  if (data === null) return <p class="empty">Reading…</p>;
  if (data.files.length === 0) return <p class="empty">The run has no files{isActive ? " yet" : ""}.</p>;
  return (
    <>
      <p class="muted">{plural(data.files.length, "file")}</p>
      <ul class="files">
        {data.files.map((file) => (
          <li key={file.name}>
            <a href={`${path}/${file.name.split("/").map(encodeURIComponent).join("/")}`} download>
              <bdi>{clip(plain(file.name), 200)}</bdi>
            </a>{" "}
            <span class="muted">{size(file.size)}</span>
          </li>
        ))}
      </ul>
    </>
  );
}

function size(bytes: number): string {
  if (bytes < 1000) return `${bytes} B`;
  return bytes < 1e6 ? `${digits(bytes / 1000)} kB` : `${digits(bytes / 1e6)} MB`;
}
