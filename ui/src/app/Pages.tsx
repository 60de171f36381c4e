// The page that belongs to the path.
import { Campaign } from "../pages/Campaign";
import { Campaigns } from "../pages/Campaigns";
import { Compare } from "../pages/Compare";
import { Lab } from "../pages/Lab";
import { Run } from "../pages/Run";
import { Runs } from "../pages/Runs";
import { Start } from "../pages/Start";
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
  const [page = "", query = ""] = path.split("?");
  const [, area = "", part = ""] = page.split("/");
  const id = decodeURIComponent(part);
  switch (area) {
    case "":
    case "runs":
      return <Runs shared={shared} />;
    case "run":
      return <Run key={id} id={id} shared={shared} />;
    case "start":
      return <Start shared={shared} />;
    case "lab":
      return <Lab shared={shared} />;
    case "campaigns":
      return <Campaigns />;
    case "campaign":
      return <Campaign key={id} id={id} />;
    case "compare":
      return <Compare query={query} shared={shared} />;
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
