//! How the service is set up.

use cullet_proto::WorkerId;
use cullet_web::WebConfig;
use std::collections::BTreeSet;
use std::net::SocketAddr;
use std::path::PathBuf;

/// How the service is set up.
#[derive(Clone, Debug, Default)]
pub struct ServiceConfig {
    /// Folder for recordings; without one it is `recordings` in the state folder.
    pub out: Option<PathBuf>,
    /// Runs at once.
    pub runs: usize,
    /// Leave after so many runs.
    pub stop_after: Option<u32>,
    /// Where metrics and health can be asked for.
    pub metrics: Option<SocketAddr>,
    /// Where the farm can be watched as a page, and by whom.
    pub web: Option<WebConfig>,
    /// Who may control the runs of others and drain workers; `None`: anybody, where no certificate
    /// says who somebody is.
    pub operators: Option<BTreeSet<WorkerId>>,
    /// Most bytes of the disk that the runs of one user may hold; `None`: no bound.
    pub quota: Option<u64>,
    /// Most memory that this process may hold before the largest run is stopped \[bytes\]; `None`:
    /// no bound.
    pub memory: Option<u64>,
    /// Bytes of the disk that are kept for runs that go on; `None`: a twentieth of it, at least
    /// 32 MiB and at most 2 GiB.
    pub reserve: Option<u64>,
    /// Runs remembered, if fewer than 4096: beyond it the oldest that is over goes.
    pub keep: Option<usize>,
    /// Bytes of the journal beyond which no run is handed in, if fewer than 256 MiB.
    pub journal: Option<u64>,
}
