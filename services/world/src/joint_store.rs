//! The books of joints.

use crate::groups::JointedGroup;
use crate::joint::{JointBreak, JointCounts};
use crate::jointed::Jointed;
use std::collections::{BTreeMap, BTreeSet};

/// A step in which joints break is taken again so often at most.
pub(crate) const MOST_RETAKES: u32 = 16;
/// All joints.
#[derive(Default)]
pub(crate) struct Joints {
    pub(crate) all: BTreeMap<u32, Jointed>,
    /// Those of each body.
    pub(crate) of: BTreeMap<u32, BTreeSet<u32>>,
    pub(crate) next: u32,
    /// What they hold together; none where that is to be found anew.
    pub(crate) groups: Option<Vec<JointedGroup>>,
    /// Those that broke in the last step.
    pub(crate) broken: Vec<JointBreak>,
    pub(crate) counts: JointCounts,
    /// How often a step is taken again at most, of [`MOST_RETAKES`].
    pub(crate) fewer_retakes: u32,
}

impl Joints {
    /// The joints of a body, in order.
    pub(crate) fn of_body(&self, id: u32) -> Vec<u32> {
        self.of.get(&id).map_or(Vec::new(), |own| own.iter().copied().collect())
    }

    pub(crate) fn bind(&mut self, id: u32, joint: &Jointed) {
        self.groups = None;
        for body in [Some(joint.a), joint.b].into_iter().flatten() {
            self.of.entry(body).or_default().insert(id);
        }
    }

    /// Takes a joint out of the books.
    pub(crate) fn unbind(&mut self, id: u32) -> Option<Jointed> {
        let joint = self.all.remove(&id)?;
        self.groups = None;
        for body in [Some(joint.a), joint.b].into_iter().flatten() {
            if let Some(own) = self.of.get_mut(&body) {
                own.remove(&id);
                if own.is_empty() {
                    self.of.remove(&body);
                }
            }
        }
        Some(joint)
    }
}
