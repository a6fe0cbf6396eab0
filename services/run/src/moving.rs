//! A sheet in a run, and the window whose time the world goes through.

use cullet_geometry::{Pose, Vec3};
use cullet_model::{
    ContinuumSetup, Handed, Proxy, ProxyMotion, SweptExtent, Window, WindowOutcome,
};
use cullet_pool::Settlement;
use cullet_proto::{JobId, WindowJob};
use cullet_scene::{Scene, SceneMovingBody};
use cullet_world::{BodyId, BodyView, World};
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// Frames in a second, about: so many at least and at most, and in a whole run where that lies
/// between.
const FRAME_RATES: [f64; 2] = [30.0, 240.0];
const FRAMES: f64 = 60.0;
/// How far beyond its reach a body counts as one that a sheet may meet, in distances of its points.
const MARGIN: f64 = 4.0;

/// A body that touches something rigid and moves less than this share of the distance of points in
/// a window rests there \[1\].
const RESTING: f64 = 0.1;

/// A sheet in the run.
pub(super) struct RunningSheet {
    /// In the recording.
    pub(super) number: u32,
    pub(super) setup: ContinuumSetup,
    pub(super) window: u32,
    pub(super) frame_every: u32,
    pub(super) two_way: bool,
    /// Whether pieces at rest become rigid bodies.
    pub(super) retire: bool,
    /// Those that have since the last window, by number.
    pub(super) retired: Vec<u32>,
    /// Coulomb's coefficient of its surface \[1\].
    pub(super) friction: f64,
    pub(super) state: Option<Arc<Vec<u8>>>,
    /// The window whose outcome that state is.
    pub(super) made_by: Option<JobId>,
    pub(super) extent: SweptExtent,
    /// The window whose time the world goes through.
    pub(super) open: Option<SheetWindowRun>,
}

/// A window that was solved and that the world goes through.
pub(super) struct SheetWindowRun {
    pub(super) job: JobId,
    pub(super) window: Window,
    /// As the window begins.
    pub(super) state: Option<Arc<Vec<u8>>>,
    pub(super) outcome: WindowOutcome,
    pub(super) solved: u32,
    /// What bodies were given, by the solve that the world went by \[N·s\].
    pub(super) given: BTreeMap<u64, Vec3>,
    /// Where the world had each body in reach after each step.
    pub(super) seen: BTreeMap<u64, Vec<Pose>>,
}

impl RunningSheet {
    fn of(number: u32, moving: &SceneMovingBody, scene: &Scene) -> Self {
        let step = scene.world.step;
        let rate = (FRAMES / scene.world.duration).clamp(FRAME_RATES[0], FRAME_RATES[1]);
        let frames = (1.0 / (rate * step * f64::from(moving.window))).round().max(1.0);
        let setup = ContinuumSetup {
            body: moving.body.clone(),
            world_step: step,
            gravity: Vec3::from(scene.world.gravity),
            seed: scene.world.seed ^ u64::from(number),
        };
        let places = moving.body.corners().into_iter();
        let (low, high) = places.fold(([f64::MAX; 3], [f64::MIN; 3]), |(low, high), place| {
            (
                std::array::from_fn(|k| low[k].min(place[k])),
                std::array::from_fn(|k| high[k].max(place[k])),
            )
        });
        let speed = moving.body.speed();
        Self {
            number,
            setup,
            window: moving.window,
            frame_every: moving.window * frames as u32,
            two_way: moving.two_way,
            retire: moving.retire,
            retired: Vec::new(),
            friction: moving.material.friction,
            state: None,
            made_by: None,
            extent: SweptExtent { low, high, speed, spacing: moving.body.spacing() },
            open: None,
        }
    }

    /// The rigid bodies that it may meet in its next window, by rising number.
    ///
    /// `object` says of which object of the scene one is; a sheet asks only where that matters.
    pub(super) fn proxies(
        &self,
        world: &World,
        gravity: f64,
        object: impl Fn(BodyId) -> Option<u32>,
    ) -> Vec<Proxy> {
        let asks = self.setup.body.asks_for_objects();
        let SweptExtent { low, high, speed, spacing } = self.extent;
        let time = f64::from(self.window) * self.setup.world_step;
        let own = speed * time + gravity * time * time + MARGIN * spacing;
        let mut proxies = Vec::new();
        for view in world.bodies() {
            let Some(body) = world.body_for_window(view.id) else { continue };
            let way = view.velocity.norm() * time + gravity * time * time;
            let reach = own + way + body.reach;
            let centre = view.pose.translation.vector;
            let outside = |k: usize| (low[k] - centre[k]).max(centre[k] - high[k]).max(0.0);
            let distance = Vec3::new(outside(0), outside(1), outside(2)).norm();
            if distance > reach {
                continue;
            }
            // What rests on something rigid would fall: its window does not know what carries it.
            let rests = body.touching && view.velocity.norm() * time < RESTING * spacing;
            let motion = match body.inertia {
                Some((mass, inertia)) if self.two_way && !rests => {
                    ProxyMotion::Free { mass, inertia }
                }
                _ => ProxyMotion::Steady,
            };
            proxies.push(Proxy {
                body: u64::from(view.id.0),
                object: if asks { object(view.id) } else { None },
                parts: body.parts,
                friction: (self.friction * body.friction).sqrt(),
                pose: view.pose,
                velocity: view.velocity,
                spin: view.spin,
                motion,
            });
        }
        proxies
    }

    pub(super) fn job(&self, state: Option<Arc<Vec<u8>>>, window: Window) -> WindowJob {
        let family = self.setup.body.family().to_owned();
        WindowJob { family, setup: self.setup.clone(), state, window }
    }
}

/// The sheets of a scene.
pub(super) fn sheets_of(scene: &Scene) -> Vec<RunningSheet> {
    (0..).zip(&scene.moving).map(|(number, body)| RunningSheet::of(number, body, scene)).collect()
}

impl SheetWindowRun {
    /// Impulse that the window has for bodies that can move, and that they did not get \[N·s\].
    pub(super) fn kept_back(&self, world: &World) -> f64 {
        let moves = |view: BodyView<'_>| !view.fixed && !view.driven;
        let can_move = |body: u64| world.body(body_id(body)).is_none_or(moves);
        let lack = |handed: &Handed| {
            let all: Vec3 = handed.impulses.iter().map(|[impulse, _]| impulse).sum();
            (all - self.given.get(&handed.body).copied().unwrap_or_default()).norm()
        };
        self.outcome.handed.iter().filter(|handed| can_move(handed.body)).map(lack).sum()
    }

    /// How far apart the world and the window have a body that the sheet touched, at most, as of
    /// the last step that both have \[m\].
    pub(super) fn gap(&self) -> f64 {
        self.apart(|handed, _, _| touched(handed))
    }

    /// The same of all bodies that are near the sheet: one that something rigid pushed into it.
    pub(super) fn stray(&self) -> f64 {
        let SweptExtent { low, high, spacing, .. } = self.outcome.extent;
        self.apart(|handed, seen, reach| {
            let at = seen.translation.vector;
            let outside = |k: usize| (low[k] - at[k]).max(at[k] - high[k]).max(0.0);
            let distance = Vec3::new(outside(0), outside(1), outside(2)).norm();
            touched(handed) || distance < reach + spacing
        })
    }

    fn apart(&self, counts: impl Fn(&Handed, &Pose, f64) -> bool) -> f64 {
        let apart = |handed: &Handed| {
            let seen = self.seen.get(&handed.body)?;
            let (own, seen) = (handed.poses.get(seen.len().checked_sub(1)?)?, seen.last()?);
            let proxy = self.window.proxies.iter().find(|proxy| proxy.body == handed.body)?;
            let reach = proxy.parts.iter().flatten().map(Vec3::norm).fold(0.0, f64::max);
            let moved = (seen.translation.vector - own.translation.vector).norm();
            let turned = seen.rotation.angle_to(&own.rotation);
            counts(handed, seen, reach).then_some(moved + turned * reach)
        };
        self.outcome.handed.iter().filter_map(apart).fold(0.0, f64::max)
    }
}

/// Whether a window gave a body anything.
pub(super) fn touched(handed: &Handed) -> bool {
    handed.impulses.iter().any(|[impulse, _]| *impulse != Vec3::zeros())
}

pub(super) fn body_id(body: u64) -> BodyId {
    BodyId(body as u32)
}

/// Settlements of fractures that came while a window was waited for.
pub(super) type Arrived = VecDeque<(JobId, Settlement)>;
