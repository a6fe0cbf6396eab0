//! What a run says of itself that is no event: that nobody works for it, that something has fallen
//! past all that could hold it, that nothing broke. Decides nothing, and is not recorded.

use super::jobs::{Idle, PoolLoad};
use cullet_geometry::Vec3;
use cullet_scene::Scene;
use cullet_world::{BodyId, Pressed, World};
use std::time::{Duration, Instant};

/// How long a run waits for workers before it says so: those of its own need a moment to start.
const GRACE: Duration = Duration::from_secs(3);

/// How long something driven is in a body before that is said \[s\]: what breaks or gives way is
/// gone sooner.
const PRESSED: f64 = 0.05;

/// What a press has gone into.
enum Pressing {
    Nothing,
    /// Which body and by what, and since when \[s\].
    Since(String, String, f64),
    Told,
}

/// What was said, and what it takes to say more.
pub(super) struct Notices {
    /// Why no job can be at work, and since when.
    idle: Option<(Idle, Instant)>,
    /// Whether that was said.
    told: bool,
    /// The direction against gravity, and how far along it the lowest fixed body reaches \[m\].
    floor: Option<(Vec3, f64)>,
    pressing: Pressing,
    /// Jobs that left a body in another shape.
    deformed: u64,
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
        let (idle, told, pressing) = (None, false, Pressing::Nothing);
        Self { idle, told, floor, pressing, deformed: 0, hits: 0, hardest: None }
    }

    /// A body has another shape.
    pub(super) fn deformed(&mut self) {
        self.deformed += 1;
    }

    /// A hit of that energy \[J\] has left a body whole.
    pub(super) fn kept(&mut self, body: BodyId, energy: f64, reason: String) {
        self.hits += 1;
        if self.hardest.as_ref().is_none_or(|(_, most, _)| energy > *most) {
            self.hardest = Some((body, energy, reason));
        }
    }
}

impl Notices {
    /// Says once that no job can be at work, and that one can again. `asked`: the solver that the
    /// next one is for.
    pub(super) fn idle(&mut self, load: &PoolLoad, asked: &str) -> Option<String> {
        match (load.idle, self.idle) {
            (None, None) => None,
            (None, Some(_)) => {
                self.idle = None;
                let told = std::mem::take(&mut self.told);
                told.then(|| "a worker is there, and the run goes on".to_owned())
            }
            (Some(idle), Some((before, since))) if idle == before => {
                if self.told || since.elapsed() < GRACE {
                    return None;
                }
                self.told = true;
                idle_line(load, asked)
            }
            (Some(idle), _) => {
                (self.idle, self.told) = (Some((idle, Instant::now())), false);
                None
            }
        }
    }

    /// Says once that a body of the scene is below all that is fixed, and falls.
    pub(super) fn fallen(&mut self, world: &World) -> Option<String> {
        let (up, floor) = self.floor?;
        let below = world.bodies().filter(|view| view.parent.is_none() && !view.fixed);
        let gravity = world.settings().gravity.norm();
        let mut below = below.filter(|view| {
            let drop = floor - up.dot(&view.pose.translation.vector);
            let speed = -up.dot(&view.velocity);
            let reach = || view.solid.mesh.vertices.iter().map(Vec3::norm).fold(0.0, f64::max);
            // What hangs or swings there is not as fast as what fell that far.
            drop > 0.0 && speed > 0.0 && speed * speed > gravity * drop && drop > reach()
        });
        let (name, time) = (below.next()?.name, world.time());
        self.floor = None;
        Some(format!(
            "warning: `{name}` has been below every fixed body since {time:.3} s and keeps falling"
        ))
    }

    /// Says once that something driven has gone into a body, and stays there.
    pub(super) fn pressed(&mut self, world: &World) -> Option<String> {
        if matches!(self.pressing, Pressing::Told) {
            return None;
        }
        let Some(Pressed { body, by, depth, share }) = world.pressed() else {
            self.pressing = Pressing::Nothing;
            return None;
        };
        let since = match &self.pressing {
            Pressing::Since(it, press, since) if it == body && press == by => *since,
            _ => {
                self.pressing = Pressing::Since(body.to_owned(), by.to_owned(), world.time());
                return None;
            }
        };
        if world.time() - since < PRESSED {
            return None;
        }
        self.pressing = Pressing::Told;
        Some(format!(
            "warning: `{by}` has gone {depth:.3e} m into `{body}`, {:.0} % of its size, since \
             {since:.3} s: bodies break in hits, and no squeeze breaks one; what work `{by}` does \
             on it from there on is that of no real press",
            100.0 * share
        ))
    }

    /// Why nothing broke.
    pub(super) fn unbroken(&mut self, world: &World) -> String {
        if self.deformed > 0 {
            let times = if self.deformed == 1 { "time" } else { "times" };
            return format!("nothing broke; something was deformed {} {times}", self.deformed);
        }
        let Some((body, energy, reason)) = self.hardest.take() else {
            return "nothing broke: no hit reached the impulse threshold of a body that can break"
                .to_owned();
        };
        let name = world.body(body).map_or("a body", |view| view.name);
        let hits = self.hits;
        format!("nothing broke: the hardest of {hits} hits, {energy:.3e} J on `{name}`: {reason}")
    }
}

/// Why no job can be at work, in words; `asked`: the solver that the next one is for.
fn idle_line(load: &PoolLoad, asked: &str) -> Option<String> {
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
    use super::{Idle, PoolLoad, idle_line};

    #[test]
    fn a_run_that_nobody_works_for_says_why() {
        let line = |idle, jobs| idle_line(&PoolLoad { jobs, permille: 0, idle }, "brittle");
        assert_eq!(line(None, 3), None);
        let none = "no worker is connected: 3 jobs of this run wait";
        assert_eq!(line(Some(Idle::NoWorker), 3).as_deref(), Some(none));
        let drained = "all workers that are connected (2) are drained: 1 job of this run waits";
        assert_eq!(line(Some(Idle::Drained(2)), 1).as_deref(), Some(drained));
        let unable = line(Some(Idle::Unable(4)), 1).expect("a line");
        assert!(unable.contains("(4) none can solve `brittle`: 1 job"), "{unable}");
    }
}
