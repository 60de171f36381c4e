"""Server of `seoro ui`: pages that show and start runs of this machine and of executors.

- `server` opens the site and serves it; `security` admits requests; `application` has the routes.
- `site` has the folders, executors and runs for all areas.
- `registry` lists the runs. `local_runs` finds those in folders.
- `feeds` reads traces once for all viewers; `run_routes` serves them.
- Each area is a module with `routes(site)`.

May import everything of seoro but `cli`, `doctor` and `executor`.
"""
