//! What workers can do, as the bits that the machine goes by.

use cullet_dispatch::{Build, Skills, Worker};
use cullet_model::PointPrecision;
use cullet_proto::pool::{Family, Hello};
use cullet_proto::{FractureJob, WindowJob};
use std::collections::{BTreeMap, BTreeSet};

/// What the last bit stands for: everything that came when no bit was left.
const LAST: usize = 63;

/// A family of solvers in one precision.
pub(super) type Skill = (String, PointPrecision);

/// Whether a worker has that family in that precision.
fn has(family: &Family, precision: PointPrecision) -> bool {
    match precision {
        PointPrecision::Single => family.single,
        PointPrecision::Double => family.double,
    }
}

/// Families as people read them.
pub(super) fn words(families: &[Family]) -> Vec<String> {
    let word = |family: &Family| {
        let single = if family.single { " single" } else { "" };
        let double = if family.double { " double" } else { "" };
        format!("{}{single}{double}", family.name)
    };
    families.iter().map(word).collect()
}

/// What a job asks of a worker: its family, and the one asked if that refuses.
pub(super) fn asks(job: &FractureJob) -> Vec<Skill> {
    let names = [Some(&job.solver), job.fallback.as_ref()].into_iter().flatten();
    names.map(|name| (name.clone(), job.problem.settings.precision)).collect()
}

/// What a window asks of a worker: its family, in double precision.
pub(super) fn asks_window(job: &WindowJob) -> Vec<Skill> {
    vec![(job.family.clone(), PointPrecision::Double)]
}

#[derive(Debug, Default)]
pub(super) struct SkillTable {
    /// Which bit is which.
    bits: Vec<Skill>,
    known: BTreeMap<Worker, (Build, Skills)>,
    /// Lacks that were reported.
    told: BTreeSet<Skills>,
}

impl SkillTable {
    fn bit(&mut self, skill: Skill) -> Skills {
        let at = self.bits.iter().position(|known| *known == skill);
        let at = at.unwrap_or_else(|| {
            self.bits.push(skill);
            self.bits.len() - 1
        });
        Skills(1 << at.min(LAST))
    }

    /// What a job asks of a worker, as bits.
    pub(super) fn need(&mut self, asks: &[Skill]) -> Skills {
        Skills(asks.iter().fold(0, |all, skill| all | self.bit(skill.clone()).0))
    }

    /// A worker says what it is.
    pub(super) fn introduce(&mut self, hello: &Hello) {
        let mut skills = if hello.families.is_none() { Skills::ALL } else { Skills::NONE };
        for family in hello.families.iter().flatten() {
            for precision in [PointPrecision::Single, PointPrecision::Double] {
                if has(family, precision) {
                    skills.0 |= self.bit((family.name.clone(), precision)).0;
                }
            }
        }
        self.known.insert(Worker(hello.session.0), (Build(hello.build), skills));
    }

    /// What a worker is, if it has said so.
    pub(super) fn get(&self, worker: Worker) -> Option<(Build, Skills)> {
        self.known.get(&worker).copied()
    }

    pub(super) fn gone(&mut self, worker: Worker) {
        self.known.remove(&worker);
    }

    /// Says once, aloud, what jobs wait for that nobody here has.
    pub(super) fn report(&mut self, unschedulable: impl Iterator<Item = (Skills, u64)>) {
        let mut still = BTreeSet::new();
        for (need, jobs) in unschedulable {
            still.insert(need);
            if !self.told.contains(&need) {
                let lack = self.words(need);
                tracing::error!("no worker here can solve {lack}: {jobs} jobs wait for one");
            }
        }
        self.told = still;
    }

    fn words(&self, need: Skills) -> String {
        let asked = self.bits.iter().enumerate().filter(|(at, _)| need.0 >> at & 1 == 1);
        let word = |(_, (name, precision)): (usize, &Skill)| format!("{name} in {precision:?}");
        asked.map(word).collect::<Vec<_>>().join(" and ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet_proto::SessionId;

    #[test]
    fn a_job_asks_for_its_families_in_its_precision() {
        let mut skill_table = SkillTable::default();
        let family = |name: &str, single, double| Family { name: name.into(), single, double };
        let hello =
            |session, families| Hello { session: SessionId(session), families, ..Hello::default() };
        let mut of = |session, families| {
            skill_table.introduce(&hello(session, families));
            skill_table.get(Worker(session)).map_or(Skills::NONE, |(_, skills)| skills)
        };
        let (any, none) = (of(1, None), of(2, Some(Vec::new())));
        let plain = of(3, Some(vec![family("brittle", false, true)]));
        let full = of(4, Some(vec![family("brittle", true, true), family("other", true, true)]));
        let mut job = FractureJob::smallest("brittle", 1);
        let mut met = |job: &FractureJob| {
            let need = skill_table.need(&asks(job));
            [any, none, plain, full].map(|skills| skills.meet(need))
        };
        assert_eq!(met(&job), [true, false, true, true]);
        job.problem.settings.precision = PointPrecision::Single;
        assert_eq!(met(&job), [true, false, false, true]);
        job.fallback = Some("unheard-of".into());
        assert_eq!(met(&job), [true, false, false, false]);
        // More families than bits: nobody who named his has the rest.
        for k in 0..100 {
            job.solver = format!("family {k}");
            assert_eq!(met(&job), [true, false, false, false]);
        }
    }
}
