//! How a pool is set up.

use crate::cache::CacheConfig;
use crate::children::SpawnConfig;
use cullet_dispatch::Timing;
use cullet_proto::security::Rules;
use cullet_proto::transport::Patience;
use std::path::PathBuf;

/// Openings of a run that may wait here: as many as a scene may have bodies.
pub(super) const MAX_HELD: usize = 100_000;

/// How a pool is set up.
#[derive(Clone, Debug)]
pub struct PoolConfig {
    /// Where to listen; `None` is loopback. Port 0 means a free one.
    pub listen: Option<String>,
    /// The router to connect to instead of listening.
    pub router: Option<String>,
    /// The coordinator's name; `None` is [`cullet_proto::keys::DEFAULT_COORDINATOR`].
    pub name: Option<String>,
    /// Worker processes to keep; `None`: they come by themselves.
    pub spawn: Option<SpawnConfig>,
    /// How patient the pool is.
    pub timing: Timing,
    /// How patient its transport is.
    pub patience: Patience,
    /// Further settings of the transport: identity and roles.
    pub rules: Rules,
    /// Which life of the coordinator this is: more than any before, and on disk before the start.
    /// Grants carry it, so that none of an earlier life is taken for one of this. `None`: drawn by
    /// chance, for a coordinator without a journal.
    pub incarnation: Option<u32>,
    /// What is kept of finished jobs, to answer repeats.
    pub cache: CacheConfig,
    /// Folder for what reproduces jobs that killed their workers; `None`: it is not kept.
    pub quarantine: Option<PathBuf>,
    /// File for the workers that were drained, who get nothing in a next life either; `None`: they
    /// would.
    pub drained: Option<PathBuf>,
    /// File for the jobs at work and the runs that want them, which a next life lets go on; `None`:
    /// it begins them anew.
    pub at_work: Option<PathBuf>,
    /// Openings of a run that may wait for room. A run that wants more is turned out: all that it
    /// has open ends, aloud.
    pub held: usize,
}

impl Default for PoolConfig {
    fn default() -> Self {
        Self {
            listen: None,
            router: None,
            name: None,
            spawn: None,
            timing: Timing::production(),
            patience: Patience::production(),
            rules: Rules::new(),
            incarnation: None,
            cache: CacheConfig::default(),
            quarantine: None,
            drained: None,
            at_work: None,
            held: MAX_HELD,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::MAX_HELD;
    use serde_json::Value;

    #[test]
    fn no_scene_has_more_bodies_than_may_wait() {
        let schema = include_str!("../../../scenes/scene.schema.json");
        let schema: Value = serde_json::from_str(schema).expect("a schema");
        let mut most = Vec::new();
        let mut rest = vec![&schema];
        while let Some(next) = rest.pop() {
            most.extend(next.get("max_bodies").and_then(|bound| bound["maximum"].as_u64()));
            rest.extend(next.as_object().into_iter().flat_map(serde_json::Map::values));
        }
        assert_eq!(most, [MAX_HELD as u64]);
    }
}
