//! A run or a sweep as one page that opens in a browser without a server.
//!
//! The page holds the model (the GLB of the export, compressed), what the recording says as JSON,
//! and the viewer: `web/` bundled with three.js into `assets/viewer.js` by `npm run build` there.
//! The bundle is in the repository, so that nothing but a browser is needed to look.

mod directed;
mod page;
mod run;
mod sweep;

pub use run::run_page;
pub use sweep::{SweepPicture, SweepTable, sweep_page};
