// Coverage: which buckets of each item have samples.
import type { RunModel } from "../data/model";
import type { CoverageItem } from "../data/types";
import { clip, digits, plain, plural, shown } from "../text";

const MOST_BUCKETS = 200;
const MOST_SAMPLES = 500;

export function Coverage({ run }: { run: RunModel }) {
  const items = run.meta.coverage.coverage ?? [];
  const { samples } = run.meta;
  return (
    <div class="coverage scrolls" tabIndex={0} role="region" aria-label="Coverage">
      {items.map((item) => (
        <Item key={`${item.kind} ${item.item}`} item={item} />
      ))}
      {samples.length > 0 && (
        <table>
          <caption>Samples</caption>
          <thead>
            <tr>
              <th scope="col">time [s]</th>
              <th scope="col">item</th>
              <th scope="col">value</th>
            </tr>
          </thead>
          <tbody>
            {samples.slice(0, MOST_SAMPLES).map((sample) => (
              <tr key={sample.seq}>
                <td>{sample.t.toFixed(3)}</td>
                <td>{clip(plain(shown(sample["item"])), 200)}</td>
                <td>
                  {clip(plain(shown(sample["value"])), 200)} {clip(plain(shown(sample["unit"] ?? "")), 20)}
                </td>
              </tr>
            ))}
          </tbody>
        </table>
      )}
    </div>
  );
}

function Item({ item }: { item: CoverageItem }) {
  const buckets = Object.entries(item.buckets);
  const hit = buckets.filter(([, count]) => count >= (item.target ?? 1)).length;
  return (
    <section>
      <h3>
        <bdi>{clip(plain(item.item), 200)}</bdi>
      </h3>
      <p>
        {hit} of {plural(item.total, "bucket")} ({digits(100 * item.grade)} %){item.text ? `: ${plain(item.text)}` : ""}
      </p>
      <meter min={0} max={Math.max(item.total, 1)} value={hit} aria-label={`Coverage of ${clip(plain(item.item), 100)}`} />
      <ul class="buckets">
        {buckets.slice(0, MOST_BUCKETS).map(([name, count]) => (
          <li key={name}>
            <bdi>{clip(plain(name), 100)}</bdi> {plural(count, "sample")}
          </li>
        ))}
      </ul>
    </section>
  );
}
