// Place in the scenario, as a button that shows it.
import type { PageState } from "../state";
import { plain, shortPlace } from "../text";

export function Place({ source, state }: { source: string; state: PageState }) {
  if (source === "") return null;
  return (
    <button type="button" class="place" title={plain(source)} onClick={() => state.showPlace(source)}>
      {plain(shortPlace(source))}
    </button>
  );
}
