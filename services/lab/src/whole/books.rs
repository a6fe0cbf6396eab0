//! What a run's events say, each at its step: hits, breaks, what they took.

use crate::specimen::whole::ResolvedProbe;
use crate::specimen::whole::format::SceneProbeKind;
use cullet_proto::recording::{EventKind, Ledger, RunEvent, Verdict};
use cullet_record::Recording;
use std::collections::{BTreeMap, BTreeSet};

/// How the values of a row come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fold {
    /// The sum of all so far.
    Sum,
    /// The greatest of all so far, 0 before any.
    Most,
    /// The one there is, from then on.
    One,
}

/// Values, each with its step.
pub(super) type Entries = Vec<(u64, f64)>;

/// The events of a recording, and which body is of what.
pub(super) struct Books<'a> {
    events: &'a [RunEvent],
    objects: BTreeMap<u64, &'a str>,
}

impl<'a> Books<'a> {
    pub(super) fn new(recording: &'a Recording) -> Self {
        let of = recording.bodies.iter().map(|body| (body.id, body.object.as_str()));
        Self { events: &recording.events, objects: of.collect() }
    }

    /// What a probe of events has to say; nothing of one that watches bodies.
    pub(super) fn entries(&self, watch: &ResolvedProbe) -> Option<(Fold, Entries)> {
        let ledger = |number: fn(&Ledger) -> f64| {
            let of = |event: &RunEvent| number(&event.ledger.unwrap_or_default());
            self.told(EventKind::Fractured, watch, &of)
        };
        let verdicts = |wanted: &'static [Verdict]| {
            let of = |event: &RunEvent| f64::from(u8::from(wanted.contains(&event.verdict())));
            self.told(EventKind::JobSettled, watch, &of)
        };
        Some(match watch.kind {
            SceneProbeKind::HitLoss => (Fold::Sum, self.hit_loss(watch)),
            SceneProbeKind::BreakLoss => (Fold::Sum, ledger(|l| l.energy_before - l.energy_after)),
            SceneProbeKind::CrackEnergy => (Fold::Sum, ledger(|l| l.fracture_energy)),
            SceneProbeKind::MassError => (Fold::Most, ledger(|l| l.mass_rel_error)),
            SceneProbeKind::VolumeError => (Fold::Most, ledger(|l| l.volume_rel_error)),
            SceneProbeKind::MomentumError => (Fold::Most, ledger(|l| l.momentum_rel_error)),
            SceneProbeKind::AngularMomentumError => {
                (Fold::Most, ledger(|l| l.angular_momentum_rel_error))
            }
            SceneProbeKind::EnergyGain => (Fold::Most, ledger(|l| l.energy_gain_rel)),
            SceneProbeKind::Breaks => (Fold::Sum, ledger(|_| 1.0)),
            SceneProbeKind::Kept => (Fold::Sum, self.told(EventKind::KeptWhole, watch, &|_| 1.0)),
            SceneProbeKind::Refused => (Fold::Sum, verdicts(&[Verdict::Refused])),
            SceneProbeKind::Failed => (Fold::Sum, verdicts(&[Verdict::Failed, Verdict::Abandoned])),
            SceneProbeKind::Hits => {
                (Fold::Sum, self.hits(watch).into_iter().map(|(_, hit)| (hit.step, 1.0)).collect())
            }
            _ => (Fold::One, self.one_hit(watch)?),
        })
    }

    fn is(&self, body: Option<u64>, names: Option<&BTreeSet<String>>) -> bool {
        let object = body.and_then(|body| self.objects.get(&body));
        names.is_none_or(|names| object.is_some_and(|object| names.contains(*object)))
    }

    /// Numbers of all events of a kind that happened to what a probe is about.
    fn told(
        &self,
        kind: EventKind,
        watch: &ResolvedProbe,
        number: &dyn Fn(&RunEvent) -> f64,
    ) -> Entries {
        let own =
            |event: &&RunEvent| event.kind() == kind && self.is(event.body, watch.bodies.as_ref());
        self.events.iter().filter(own).map(|event| (event.step, number(event))).collect()
    }

    /// The hits that a probe is about, each with how many hits were reported in earlier steps.
    fn hits(&self, watch: &ResolvedProbe) -> Vec<(u64, &RunEvent)> {
        let (mut earlier, mut now, mut step) = (0, 0, 0);
        let mut found = Vec::new();
        for event in self.events.iter().filter(|event| event.kind() == EventKind::Impact) {
            if event.step > step {
                (earlier, step) = (now, event.step);
            }
            now += 1;
            if self.is(event.body, watch.bodies.as_ref())
                && self.is(event.striker, watch.others.as_ref())
            {
                found.push((earlier, event));
            }
        }
        found
    }

    /// A number of one hit; nothing where the kind asks for none.
    fn one_hit(&self, watch: &ResolvedProbe) -> Option<Entries> {
        let number: fn(u64, &RunEvent) -> f64 = match watch.kind {
            SceneProbeKind::HitOrder => |earlier, _| earlier as f64 + 1.0,
            SceneProbeKind::HitTime => |_, hit| hit.time,
            SceneProbeKind::HitSpeed => |_, hit| hit.closing_speed,
            SceneProbeKind::HitImpulse => |_, hit| hit.impulse,
            SceneProbeKind::HitEnergy => |_, hit| hit.energy,
            SceneProbeKind::HitTook => |_, hit| hit.dissipated,
            SceneProbeKind::HitMass => {
                |_, hit| 2.0 * hit.energy / (hit.closing_speed * hit.closing_speed)
            }
            SceneProbeKind::HitDuration => |_, hit| hit.duration,
            SceneProbeKind::HitRadius => |_, hit| hit.radius,
            SceneProbeKind::HitForce => |_, hit| hit.peak_force,
            _ => return None,
        };
        let hits = self.hits(watch);
        let one = hits.get(watch.nth).map(|(earlier, hit)| (hit.step, number(*earlier, hit)));
        Some(one.into_iter().collect())
    }

    /// What hits took; at a break, what the hits that led to it took is given back: the break's
    /// own entry has it.
    fn hit_loss(&self, watch: &ResolvedProbe) -> Entries {
        let names = watch.bodies.as_ref();
        let mut entries = Entries::new();
        // Of each step and pair, what it took: both bodies of a pair may have a report of it.
        let mut taken: BTreeMap<(u64, u64, u64), f64> = BTreeMap::new();
        // The step of the hits that each body's last job is about.
        let mut asked: BTreeMap<u64, u64> = BTreeMap::new();
        for event in self.events {
            let Some(body) = event.body else { continue };
            match event.kind() {
                EventKind::Impact => {
                    let striker = event.striker.unwrap_or(u64::MAX);
                    let pair = (event.step, body.min(striker), body.max(striker));
                    let of = self.is(event.body, names) || self.is(event.striker, names);
                    if of && !taken.contains_key(&pair) {
                        taken.insert(pair, event.dissipated);
                        entries.push((event.step, event.dissipated));
                    }
                }
                // A finer job for the same hits has no hits in its own step.
                EventKind::JobOpened if taken.keys().any(|k| of_hit(k, event.step, body)) => {
                    asked.entry(body).or_insert(event.step);
                }
                EventKind::KeptWhole => {
                    asked.remove(&body);
                }
                EventKind::Fractured => {
                    let step = asked.remove(&body).unwrap_or(u64::MAX);
                    for (_, took) in taken.iter_mut().filter(|(key, _)| of_hit(key, step, body)) {
                        entries.push((event.step, -std::mem::take(took)));
                    }
                }
                _ => {}
            }
        }
        entries
    }
}

/// Whether a hit is one of a body at a step.
fn of_hit(&(at, one, two): &(u64, u64, u64), step: u64, body: u64) -> bool {
    at == step && (one == body || two == body)
}
