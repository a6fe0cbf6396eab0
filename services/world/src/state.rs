//! All that a world holds between two steps. The operations are functions over it, a file each;
//! [`crate::World`] is the door to them.

use crate::body::Body;
use crate::episode::Episodes;
use crate::exchange::PendingExchange;
use crate::frozen::Frozen;
use crate::grains::Debris;
use crate::joint_store::Joints;
use crate::ledger::{Flows, Sink};
use crate::resting::Resting;
use crate::rigid::Rigid;
use crate::settings::WorldSettings;
use crate::settling::Settling;
use cullet_geometry::Vec3;
use std::collections::BTreeMap;

/// The state of a world.
pub(crate) struct WorldState {
    pub(crate) settings: WorldSettings,
    pub(crate) rigid: Rigid,
    pub(crate) bodies: BTreeMap<u32, Body>,
    pub(crate) replaced: ReplacedBodies,
    pub(crate) episodes: Episodes,
    /// What the pairs that rest did lately.
    pub(crate) resting: Resting,
    /// Bodies that nothing has struck yet.
    pub(crate) settling: Settling,
    pub(crate) debris: Debris,
    pub(crate) next_id: u32,
    pub(crate) frozen: Frozen,
    pub(crate) steps: u64,
    pub(crate) joints: Joints,
    /// What came in and went out so far.
    pub(crate) flows: Flows,
    /// Work of each driven body on the others \[J\].
    pub(crate) driven_work: BTreeMap<u32, f64>,
    /// Accelerations of the next step, beside gravity \[m/s²\].
    pub(crate) fields: BTreeMap<u32, Vec3>,
    /// Those of the last one.
    pub(crate) last_fields: BTreeMap<u32, Vec3>,
}

/// What replacements leave behind.
#[derive(Default)]
pub(crate) struct ReplacedBodies {
    /// The fragments of each body that broke.
    pub(crate) children: BTreeMap<u32, Vec<u32>>,
    /// What a replacement already settled for the other body of an episode, by episode and body.
    pub(crate) pending: BTreeMap<(u64, u32), PendingExchange>,
    /// What fixed bodies took up.
    pub(crate) sink: Sink,
}

impl ReplacedBodies {
    /// Drops what was settled for a body, whichever the episode.
    pub(crate) fn drop_pending(&mut self, id: u32) {
        self.pending.retain(|&(_, body), _| body != id);
    }

    /// Adds what a replacement gave to fixed bodies.
    pub(crate) fn add_to_sink(&mut self, given: &Sink) {
        self.sink.linear += given.linear;
        self.sink.angular += given.angular;
    }
}

impl WorldState {
    pub(crate) fn new(settings: WorldSettings) -> Self {
        Self {
            rigid: Rigid::new(&settings),
            settings,
            bodies: BTreeMap::new(),
            replaced: ReplacedBodies::default(),
            episodes: Episodes::default(),
            resting: Resting::default(),
            settling: Settling::default(),
            debris: Debris::default(),
            next_id: 0,
            frozen: Frozen::default(),
            steps: 0,
            joints: Joints::default(),
            flows: Flows::default(),
            driven_work: BTreeMap::new(),
            fields: BTreeMap::new(),
            last_fields: BTreeMap::new(),
        }
    }

    /// Simulated time \[s\].
    pub(crate) fn time(&self) -> f64 {
        self.steps as f64 * self.settings.step
    }

    /// An id that no body has had.
    pub(crate) fn take_id(&mut self) -> u32 {
        self.next_id += 1;
        self.next_id - 1
    }
}
