//! The joints that a recording knows.

use cullet_world::{BodyId, JointId};
use std::collections::BTreeMap;

/// The bodies of each joint that is recorded and not at its end.
pub(super) type KnownJoints = BTreeMap<JointId, (BodyId, Option<BodyId>)>;
