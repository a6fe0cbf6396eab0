//! What of a run was directed: driven bodies, joints, bodies that fields or bounds removed, hits
//! with settings of their own, pieces. These are choices of the scene, as sampled fragments are
//! draws; all else was solved.

use cullet_model::outcome::{ADDED_CRACK_AREA, CLOSED_CRACK_AREA};
use cullet_proto::recording::{BodyJoint, EventKind, JobReport, RunEvent, Sampled};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// What directed a run, in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DirectedTotals {
    /// Bodies that keyframes moved.
    pub driven: u64,
    /// Work that they did on others, summed \[J\].
    pub driven_work: f64,
    /// Joints that the scene made, those of glue counted.
    pub joints: u64,
    /// Of these, between faces that are glued.
    pub glue_joints: u64,
    /// Joints that fragments got in place of one of the body that they come from.
    pub joints_inherited: u64,
    /// Joints that broke under their load, inherited ones counted.
    pub joints_broken: u64,
    /// Joints that went with a body that broke or was removed, inherited ones counted.
    pub joints_gone: u64,
    /// Bodies that fields or the bounds of the world removed.
    pub removed: u64,
    /// Hits that were solved with settings of their own.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub hits: u64,
    /// Bodies whose strength the scene painted; no key where none was.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub painted: u64,
    /// Fragments that were divided or joined because the scene asked for it; no key where none was.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub pieces: u64,
    /// Crack area that this added, which cost no energy \[m²\]; no key likewise.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub added_crack_area: f64,
    /// Crack area that this closed again, whose energy stays spent \[m²\]; no key likewise.
    #[serde(default, skip_serializing_if = "is_nothing")]
    pub closed_crack_area: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde hands out references")]
fn is_nothing(amount: &f64) -> bool {
    *amount == 0.0
}

impl fmt::Display for DirectedTotals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        if self.driven > 0 {
            let (bodies, work) = (counted(self.driven, "body", "bodies"), self.driven_work);
            parts.push(format!("{bodies} moved by keyframes, {work:.3e} J of work on others"));
        }
        if self.joints > 0 {
            let inherited = match self.joints_inherited {
                0 => String::new(),
                of => format!(", {of} passed on to fragments"),
            };
            let joints = counted(self.joints, "joint", "joints");
            let glue = match self.glue_joints {
                0 => String::new(),
                of => format!(" ({of} of glue)"),
            };
            let (broken, gone) = (self.joints_broken, self.joints_gone);
            parts.push(format!(
                "{joints}{glue} of given strength{inherited}, {broken} broken, {gone} gone with \
                 their bodies"
            ));
        }
        if self.removed > 0 {
            parts.push(format!("{} removed", counted(self.removed, "body", "bodies")));
        }
        if self.hits > 0 {
            let (hits, whose) = (counted(self.hits, "hit", "hits"), self.hits);
            let whose = if whose == 1 { "its" } else { "their" };
            parts.push(format!("{hits} solved with settings of {whose} own"));
        }
        if self.painted > 0 {
            parts.push(format!("strength painted on {}", counted(self.painted, "body", "bodies")));
        }
        if self.pieces > 0 {
            let pieces = counted(self.pieces, "piece", "pieces");
            let (added, closed) = (self.added_crack_area, self.closed_crack_area);
            parts.push(format!(
                "{pieces} as the scene wants them, {added:.3e} m² of cracks added at no cost, \
                 {closed:.3e} m² closed"
            ));
        }
        write!(f, "directed: {}", parts.join("; "))
    }
}

fn counted(count: u64, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// Adds up what directed a run.
#[derive(Clone, Debug, Default)]
pub(super) struct DirectedCensus {
    totals: DirectedTotals,
    /// Crack area that the direction of each job added, and that it closed \[m²\].
    areas: BTreeMap<Vec<u8>, [f64; 2]>,
}

impl DirectedCensus {
    pub(super) fn joint(&mut self, joint: &BodyJoint) {
        if joint.inherited {
            self.totals.joints_inherited += 1;
        } else {
            self.totals.joints += 1;
            self.totals.glue_joints += u64::from(joint.glue);
        }
    }

    pub(super) fn pieces(&mut self, of: &Sampled) {
        self.totals.pieces += of.directed.len() as u64;
        let [added, closed] = self.areas.get(&of.job).copied().unwrap_or_default();
        self.totals.added_crack_area += added;
        self.totals.closed_crack_area += closed;
    }

    pub(super) fn report(&mut self, report: &JobReport) {
        let figure = |name| report.details.iter().find(|it| it.name == name).map(|it| it.value);
        let areas = [ADDED_CRACK_AREA, CLOSED_CRACK_AREA].map(figure);
        if areas != [None; 2] {
            self.areas.insert(report.job.clone(), areas.map(Option::unwrap_or_default));
        }
    }

    pub(super) fn event(&mut self, event: &RunEvent) {
        match event.kind() {
            EventKind::JointBroken => self.totals.joints_broken += 1,
            EventKind::JointGone => self.totals.joints_gone += 1,
            EventKind::Removed => self.totals.removed += 1,
            EventKind::JobOpened => self.totals.hits += u64::from(event.directed),
            EventKind::Driven => {
                self.totals.driven += 1;
                self.totals.driven_work += event.energy;
            }
            _ => {}
        }
    }

    /// The totals, with so many bodies whose strength was painted; nothing where nothing was
    /// directed.
    pub(super) fn totals(&self, painted: u64) -> Option<DirectedTotals> {
        let totals = DirectedTotals { painted, ..self.totals.clone() };
        (totals != DirectedTotals::default()).then_some(totals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_proto::recording::ReportFigure;

    #[test]
    fn what_was_directed_is_counted_once() {
        let mut directed = DirectedCensus::default();
        assert_eq!(directed.totals(0), None);
        for (id, glue, inherited) in [(0, true, false), (1, false, false), (2, true, true)] {
            directed.joint(&BodyJoint { id, glue, inherited, ..BodyJoint::default() });
        }
        for (kind, energy) in [
            (EventKind::JointBroken, 0.0),
            (EventKind::Driven, 2.5),
            (EventKind::Driven, 1.5),
            (EventKind::Removed, 0.0),
            (EventKind::Impact, 7.0),
        ] {
            directed.event(&RunEvent { kind: kind as i32, energy, ..RunEvent::default() });
        }
        let totals = directed.totals(0).expect("something was");
        assert_eq!((totals.joints, totals.glue_joints, totals.joints_broken), (2, 1, 1));
        assert_eq!(
            totals.to_string(),
            "directed: 2 bodies moved by keyframes, 4.000e0 J of work on others; 2 joints (1 of \
             glue) of given strength, 1 passed on to fragments, 1 broken, 0 gone with their \
             bodies; 1 body removed"
        );
        let mut directed = DirectedCensus::default();
        let [name, unit] = [ADDED_CRACK_AREA, "m²"].map(str::to_owned);
        let details = vec![ReportFigure { name, unit, value: 0.25 }];
        directed.report(&JobReport { job: vec![7], details, ..JobReport::default() });
        let painted = directed.totals(1).expect("painted").to_string();
        assert_eq!(painted, "directed: strength painted on 1 body");
        assert_eq!(directed.totals(0), None, "what a job found is not yet in the world");
        let (job, pieces) = (vec![7], vec![3, 4]);
        directed.pieces(&Sampled { job, directed: pieces, ..Sampled::default() });
        assert_eq!(
            directed.totals(0).expect("pieces").to_string(),
            "directed: 2 pieces as the scene wants them, 2.500e-1 m² of cracks added at no cost, \
             0.000e0 m² closed"
        );
    }
}
