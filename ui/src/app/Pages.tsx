// The page that belongs to the path.
import { Run } from "../pages/Run";
import { Runs } from "../pages/Runs";
import { useCell } from "../state";
import { useTitle } from "./hooks";
import { Link, location_ } from "./router";
import { Shell } from "./Shell";
import type { Shared } from "./stores";

export function Pages({ shared }: { shared: Shared }) {
  const path = useCell(location_);
  return <Shell shared={shared}>{pageOf(path, shared)}</Shell>;
}

function pageOf(path: string, shared: Shared) {
  const [, area = "", id = ""] = path.split("?")[0]!.split("/");
  switch (area) {
    case "":
    case "runs":
      return <Runs shared={shared} />;
    case "run":
      return <Run key={id} id={decodeURIComponent(id)} shared={shared} />;
    default:
      return <Unknown />;
  }
}

function Unknown() {
  useTitle("Unknown page");
  return (
    <section class="panel">
      <h1>Unknown page</h1>
      <p>
        This address has no page. Go to the <Link href="/runs">runs</Link>.
      </p>
    </section>
  );
}
