//! What a run says of itself that is no event: that nobody works for it, that something has fallen
//! past all that could hold it, that nothing broke. Decides nothing, and is not recorded.

use super::{Idle, Load, Run};
use cullet_geometry::Vec3;
use cullet_scene::Scene;
use cullet_world::BodyId;
use std::time::{Duration, Instant};

/// How long a run waits for workers before it says so: those of its own need a moment to start.
const GRACE: Duration = Duration::from_secs(3);

/// What was said, and what it takes to say more.
pub(super) struct Notices {
    /// Why no job can be at work, and since when.
    idle: Option<(Idle, Instant)>,
    /// Whether that was said.
    told: bool,
    /// The direction against gravity, and how far along it the lowest fixed body reaches \[m\].
    floor: Option<(Vec3, f64)>,
    /// Hits that broke nothing.
    hits: u64,
    /// The hardest of them: whose, its energy \[J\], and why.
    hardest: Option<(BodyId, f64, String)>,
}

impl Notices {
    pub(super) fn of(scene: &Scene) -> Self {
        let up = (-Vec3::from(scene.world.gravity)).try_normalize(1e-12);
        let fixed = || scene.bodies.iter().filter(|body| body.fixed);
        let lowest = |up: &Vec3| {
            let corners = fixed().flat_map(|body| {
                let corners = body.hulls.iter().flatten();
                corners.map(|p| up.dot(&(body.pose.rotation * p + body.pose.translation.vector)))
            });
            corners.fold(f64::INFINITY, f64::min)
        };
        let floor = up.map(|up| (up, lowest(&up))).filter(|(_, lowest)| lowest.is_finite());
        Self { idle: None, told: false, floor, hits: 0, hardest: None }
    }

    /// A hit of that energy \[J\] has left a body whole.
    pub(super) fn kept(&mut self, body: BodyId, energy: f64, reason: String) {
        self.hits += 1;
        if self.hardest.as_ref().is_none_or(|(_, most, _)| energy > *most) {
            self.hardest = Some((body, energy, reason));
        }
    }
}

impl Run<'_> {
    /// Says once that no job can be at work, and that it can again.
    pub(super) fn tell_idle(&mut self, load: &Load) {
        match (load.idle, self.notices.idle) {
            (None, None) => {}
            (None, Some(_)) => {
                self.notices.idle = None;
                if std::mem::take(&mut self.notices.told) {
                    self.say("a worker is there, and the run goes on");
                }
            }
            (Some(idle), Some((before, since))) if idle == before => {
                if !self.notices.told && since.elapsed() >= GRACE {
                    self.notices.told = true;
                    let asked = self.pending.front().map_or("", |pending| &pending.asked);
                    let line = idle_line(load, asked).unwrap_or_default();
                    self.say(line);
                }
            }
            (Some(idle), _) => {
                (self.notices.idle, self.notices.told) = (Some((idle, Instant::now())), false);
            }
        }
    }

    /// Says once that a body of the scene is below all that is fixed, and falls.
    pub(super) fn tell_fallen(&mut self) {
        let Some((up, floor)) = self.notices.floor else {
            return;
        };
        let below = self.world.bodies().filter(|view| view.parent.is_none() && !view.fixed);
        let mut below = below.filter(|view| {
            let height = up.dot(&view.pose.translation.vector);
            let reach = || view.solid.mesh.vertices.iter().map(Vec3::norm).fold(0.0, f64::max);
            height < floor && up.dot(&view.velocity) < 0.0 && height + reach() < floor
        });
        if let Some(view) = below.next() {
            let (name, time) = (view.name.to_owned(), self.world.time());
            drop(below);
            self.notices.floor = None;
            self.say(format!(
                "warning: `{name}` is below all that is fixed since {time:.3} s, and only falls"
            ));
        }
    }

    /// Says why nothing broke, if so.
    pub(super) fn tell_unbroken(&mut self) {
        if self.fractures > 0 || !self.scene.bodies.iter().any(|body| body.breakable) {
            return;
        }
        let line = match self.notices.hardest.take() {
            None => "nothing broke: no hit reached the impulse threshold of a body that can break"
                .to_owned(),
            Some((body, energy, reason)) => {
                let name = self.world.body(body).map_or("a body", |view| view.name);
                let hits = self.notices.hits;
                format!(
                    "nothing broke: the hardest of {hits} hits, {energy:.3e} J on `{name}`: \
                     {reason}"
                )
            }
        };
        self.say(line);
    }
}

/// Why no job can be at work, in words; `asked`: the solver that the next one is for.
fn idle_line(load: &Load, asked: &str) -> Option<String> {
    let why = match load.idle? {
        Idle::NoWorker => "no worker is connected".to_owned(),
        Idle::Drained(workers) => format!("all workers that are connected ({workers}) are drained"),
        Idle::Unable(workers) => {
            format!("of the workers that are connected ({workers}) none can solve `{asked}`")
        }
    };
    Some(match load.jobs {
        0 => format!("{why}: a job of this run would wait"),
        1 => format!("{why}: 1 job of this run waits"),
        jobs => format!("{why}: {jobs} jobs of this run wait"),
    })
}

#[cfg(test)]
mod tests {
    use super::{Idle, Load, idle_line};

    #[test]
    fn a_run_that_nobody_works_for_says_why() {
        let line = |idle, jobs| idle_line(&Load { jobs, permille: 0, idle }, "brittle");
        assert_eq!(line(None, 3), None);
        let none = "no worker is connected: 3 jobs of this run wait";
        assert_eq!(line(Some(Idle::NoWorker), 3).as_deref(), Some(none));
        let drained = "all workers that are connected (2) are drained: 1 job of this run waits";
        assert_eq!(line(Some(Idle::Drained(2)), 1).as_deref(), Some(drained));
        let unable = line(Some(Idle::Unable(4)), 1).expect("a line");
        assert!(unable.contains("(4) none can solve `brittle`: 1 job"), "{unable}");
    }
}
