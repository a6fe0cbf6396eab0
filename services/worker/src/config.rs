//! How a worker is set up.

use crate::job::JobCommand;
use cullet_proto::keys;
use cullet_proto::pool::Family;
use cullet_proto::security::Rules;
use cullet_proto::transport::Patience;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// How a worker is set up.
#[derive(Clone, Debug)]
pub struct WorkerConfig {
    /// Endpoints of the coordinator, as `tcp/127.0.0.1:7447`.
    pub connect: Vec<String>,
    /// The worker's name: 1 to 40 of `a-z`, `0-9`, `-`.
    pub name: String,
    /// The coordinator's name.
    pub coordinator: String,
    /// Threads that a job gets.
    pub threads: usize,
    /// End the process when its standard input ends: the parent is gone, however it ended.
    pub parent_watch: bool,
    /// End this process with [`crate::EXIT_WEDGED`] when a solver on a thread of it hangs past the
    /// hard limit. Only that ends such a thread; without this it is left behind.
    pub exit_when_wedged: bool,
    /// The process in which jobs run; `None`: a thread of this one, for tests.
    pub job: Option<JobCommand>,
    /// Families of solvers that it has, as it tells the coordinator; `None`: whatever it is asked.
    pub families: Option<Vec<Family>>,
    /// The digest of the program that solves; `None`: found by reading it.
    pub build: Option<[u8; 32]>,
    /// Most bytes of meshes kept for the next job.
    pub meshes: u64,
    /// How patient the transport is.
    pub patience: Patience,
    /// Further settings of the transport: its identity.
    pub rules: Rules,
    /// The name in the certificate that it shows.
    pub certificate: Option<String>,
    /// Return from [`crate::run`] after this long without a job, also where no coordinator answers;
    /// `None`: stay.
    pub idle_limit: Option<Duration>,
    /// Set to make [`crate::run`] return: the job at hand is given back.
    pub stop: Arc<AtomicBool>,
}

impl Default for WorkerConfig {
    fn default() -> Self {
        Self {
            connect: Vec::new(),
            name: format!("w-{}", std::process::id()),
            coordinator: keys::DEFAULT_COORDINATOR.into(),
            threads: 1,
            parent_watch: false,
            exit_when_wedged: true,
            job: None,
            families: None,
            build: None,
            meshes: 256 << 20,
            patience: Patience::production(),
            rules: Rules::new(),
            certificate: None,
            idle_limit: None,
            stop: Arc::default(),
        }
    }
}

impl WorkerConfig {
    /// A worker of that name for the coordinator at these endpoints, the rest by default.
    #[must_use]
    pub fn new(connect: Vec<String>, name: String) -> Self {
        Self { connect, name, ..Self::default() }
    }
}
