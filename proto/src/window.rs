//! A window of the time of a body that moves as it deforms, on its way to a worker, and what came
//! of it.
//!
//! What is large in a job travels by its digest: the body, which is the same from window to window,
//! the bodies in its reach, and its state, which the worker that made it has already.

mod outcome;
mod poses;

pub use crate::bounds::{MAX_PARTS_OF_PROXY, MAX_PROXIES, MAX_WINDOW_STEPS};
pub use outcome::{decode_outcome, encode_outcome, state_of};

use crate::bounds::MAX_SOLVER;
use crate::codec::{self, MAX_RECORD, WireError};
use crate::envelope::{self, MessageKind};
use crate::ids::{JobId, digest};
use crate::mesh::{self, Slabs};
use cullet_geometry::{Solid, Vec3};
use cullet_model::{ContinuumBody, ContinuumSetup, ProxyMotion, Window};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// In place of the number of an object that is none of the scene's.
const NO_OBJECT: u32 = u32::MAX;
/// Largest state \[bytes\].
pub use cullet_model::sheet_check::MAX_STATE;

/// A window to be solved.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowJob {
    /// Name of the family.
    pub family: String,
    /// The body.
    pub setup: ContinuumSetup,
    /// How it is as the window begins; `None`: as it is at the start of a scene.
    pub state: Option<Arc<Vec<u8>>>,
    /// The window.
    pub window: Window,
}

/// Vertices and triangles of a body's solid, if it has one.
type SolidCounts = Option<(u32, u32)>;

#[derive(Serialize, Deserialize)]
struct WindowHeader {
    family: String,
    /// Bytes of the body's numbers.
    setup: u64,
    solid: SolidCounts,
    /// Bytes of the window's numbers.
    window: u64,
    /// \[bytes\].
    state: Option<u64>,
}

/// A window and how much of it travels behind its numbers.
#[derive(Serialize, Deserialize)]
struct WindowRecord {
    window: Window,
    /// Corners of each convex part of each body in reach.
    corners: Vec<Vec<u32>>,
    /// Poses of each led body.
    led: Vec<u32>,
}

impl WindowJob {
    /// The canonical bytes: equal windows give equal bytes.
    ///
    /// # Errors
    /// The limit of the wire that the window breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        Ok(self.slabs()?.0)
    }

    /// The canonical bytes, and where in them the body, the bodies in reach and the state are.
    pub(crate) fn slabs(&self) -> Result<(Vec<u8>, [Range<usize>; 3]), WireError> {
        let record = WindowRecord::of(&self.window);
        record.check(self.setup.world_step, &self.setup.gravity)?;
        let window = codec::encode_record(&record)?;
        let (mut slabs, numbers, solid) = self.body()?;
        let header = WindowHeader {
            family: self.family.clone(),
            setup: numbers,
            solid,
            window: window.len() as u64,
            state: self.state.as_ref().map(|state| state.len() as u64),
        };
        header.check()?;
        let first = slabs.len();
        slabs.extend_from_slice(&window);
        for proxy in &self.window.proxies {
            proxy.parts.iter().for_each(|part| mesh::put_points(&mut slabs, part));
            if let ProxyMotion::Led(led) = &proxy.motion {
                poses::put(&mut slabs, led);
            }
        }
        if self.setup.body.asks_for_objects() {
            let objects = self.window.proxies.iter();
            mesh::put_u32s(&mut slabs, objects.map(|proxy| proxy.object.unwrap_or(NO_OBJECT)));
        }
        let second = slabs.len();
        slabs.extend_from_slice(self.state.as_ref().map_or(&[], |state| state.as_slice()));
        let bytes = envelope::seal(MessageKind::WindowJob, &header, &slabs)?;
        let start = bytes.len() - slabs.len();
        let [first, second, last] = [first, second, slabs.len()].map(|at| start + at);
        Ok((bytes, [start..first, first..second, second..last]))
    }

    /// The slab of the body, the bytes of its numbers, and the counts of its solid.
    fn body(&self) -> Result<(Vec<u8>, u64, SolidCounts), WireError> {
        let mut slab = codec::encode_record(&self.setup)?;
        if let ContinuumBody::Membrane(sheet) = &self.setup.body
            && let Some(further) = sheet.diffusion.further()
        {
            slab.extend(codec::encode_record(&further)?);
        }
        let numbers = slab.len() as u64;
        let solid = solid_of(&self.setup);
        let counts = solid.map(mesh::counts).transpose()?;
        if let Some(solid) = solid {
            mesh::put_solid(&mut slab, solid);
        }
        Ok((slab, numbers, counts))
    }

    /// Whether these bytes hold a window.
    #[must_use]
    pub fn is(bytes: &[u8]) -> bool {
        envelope::is(MessageKind::WindowJob, bytes)
    }

    /// The window in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        let (header, slabs) = envelope::open::<WindowHeader>(MessageKind::WindowJob, bytes)?;
        header.check()?;
        let mut slabs = Slabs::new(slabs);
        let numbers = slabs.take("a body's numbers", header.setup as usize, 1)?;
        let mut setup = setup_of(numbers)?;
        match (&mut setup.body, header.solid) {
            (ContinuumBody::Soft(body), Some((vertices, triangles))) => {
                body.solid = Arc::new(slabs.solid(vertices, triangles)?);
            }
            (ContinuumBody::Soft(_), None) | (_, Some(_)) => {
                let why = "a soft body comes with its solid, a sheet without one";
                return Err(WireError::Header(why.to_owned()));
            }
            (_, None) => {}
        }
        let numbers = slabs.take("a window's numbers", header.window as usize, 1)?;
        let mut record: WindowRecord = codec::decode_record(numbers)?;
        record.fill(&mut slabs)?;
        if setup.body.asks_for_objects() {
            let proxies = &mut record.window.proxies;
            let objects = slabs.u32s("objects of bodies in reach", proxies.len())?;
            for (proxy, object) in proxies.iter_mut().zip(objects) {
                proxy.object = (object != NO_OBJECT).then_some(object);
            }
        }
        record.check(setup.world_step, &setup.gravity)?;
        let state = match header.state {
            Some(length) => Some(slabs.take("a window's state", length as usize, 1)?.to_vec()),
            None => None,
        };
        slabs.end("a window")?;
        let (family, window) = (header.family, record.window);
        Ok(Self { family, setup, state: state.map(Arc::new), window })
    }

    /// The digest of [`WindowJob::encode`].
    ///
    /// # Errors
    /// As [`WindowJob::encode`].
    pub fn id(&self) -> Result<JobId, WireError> {
        Ok(JobId::of(&self.encode()?))
    }

    /// The digest of the body and its family: what it is prepared for once.
    ///
    /// # Errors
    /// As [`WindowJob::encode`].
    pub fn setup_digest(&self) -> Result<[u8; 32], WireError> {
        let slab = self.body()?.0;
        Ok(digest(&[self.family.as_bytes(), &[0], &slab].concat()))
    }
}

/// The body in these numbers. What a sheet takes up beside a first quantity stands behind them.
fn setup_of(numbers: &[u8]) -> Result<ContinuumSetup, WireError> {
    let (mut setup, used) = codec::decode_first_record::<ContinuumSetup>(numbers)?;
    match (&mut setup.body, &numbers[used..]) {
        (_, []) => {}
        (ContinuumBody::Membrane(sheet), further) => {
            sheet.diffusion.join(codec::decode_record(further)?);
            let again = sheet.diffusion.further().map(|it| codec::encode_record(&it));
            if again.transpose()?.as_deref() != Some(further) {
                let why = "what a sheet takes up beside a first quantity is not canonical";
                return Err(WireError::Header(why.to_owned()));
            }
        }
        (_, rest) => {
            let (what, extra) = ("a body's numbers", rest.len());
            return Err(WireError::Trailing { what, extra });
        }
    }
    Ok(setup)
}

/// The solid of a body that has one.
fn solid_of(setup: &ContinuumSetup) -> Option<&Solid> {
    match &setup.body {
        ContinuumBody::Soft(body) => Some(&body.solid),
        _ => None,
    }
}

impl WindowHeader {
    fn check(&self) -> Result<(), WireError> {
        codec::limit("a family name's length", self.family.len() as u64, MAX_SOLVER as u64)?;
        codec::limit("a body's numbers", self.setup, MAX_RECORD as u64)?;
        codec::limit("a window's numbers", self.window, MAX_RECORD as u64)?;
        codec::limit("a window's state", self.state.unwrap_or(0), MAX_STATE)
    }
}

impl WindowRecord {
    fn of(window: &Window) -> Self {
        let count = |part: &Vec<Vec3>| part.len() as u32;
        let led = |motion: &ProxyMotion| match motion {
            ProxyMotion::Led(poses) => poses.len() as u32,
            _ => 0,
        };
        let proxies = &window.proxies;
        Self {
            window: window.clone(),
            corners: proxies.iter().map(|it| it.parts.iter().map(count).collect()).collect(),
            led: proxies.iter().map(|it| led(&it.motion)).collect(),
        }
    }

    /// Takes what travels behind the numbers.
    fn fill(&mut self, slabs: &mut Slabs<'_>) -> Result<(), WireError> {
        let counts = self.corners.iter().zip(&self.led);
        for (proxy, (corners, &led)) in self.window.proxies.iter_mut().zip(counts) {
            let part = |count: &u32| slabs.points("corners of a body in reach", *count as usize);
            proxy.parts = corners.iter().map(part).collect::<Result<_, _>>()?;
            if let ProxyMotion::Led(poses) = &mut proxy.motion {
                *poses = poses::take(slabs, "poses of a led body", led as usize)?;
            }
        }
        Ok(())
    }

    fn check(&self, world_step: f64, gravity: &Vec3) -> Result<(), WireError> {
        let Window { steps, frame_every, proxies, .. } = &self.window;
        codec::limit("steps of a window", u64::from(*steps), MAX_WINDOW_STEPS)?;
        codec::limit("a window without steps", 1, u64::from(*steps))?;
        codec::limit("a window without frames", 1, u64::from(*frame_every))?;
        codec::limit("bodies in a window's reach", proxies.len() as u64, MAX_PROXIES as u64)?;
        codec::limit("bodies with corners", self.corners.len() as u64, proxies.len() as u64)?;
        codec::limit("bodies without corners", proxies.len() as u64, self.corners.len() as u64)?;
        codec::limit("bodies with poses", self.led.len() as u64, proxies.len() as u64)?;
        codec::limit("bodies without poses", proxies.len() as u64, self.led.len() as u64)?;
        let retired = self.window.retired.as_ref().map_or(0, Vec::len);
        codec::limit("pieces that became rigid", retired as u64, MAX_PROXIES as u64)?;
        codec::finite("a window's step", &[world_step])?;
        codec::finite("a window's gravity", gravity.as_slice())?;
        for (proxy, corners) in proxies.iter().zip(&self.corners) {
            let parts = corners.len() as u64;
            codec::limit("a body's convex parts", parts, MAX_PARTS_OF_PROXY as u64)?;
            let motion = [proxy.velocity.as_slice(), proxy.spin.as_slice()].concat();
            codec::finite("a body in reach", &motion)?;
            codec::finite("a body in reach", &[proxy.friction])?;
            poses::check(&proxy.pose)?;
            match &proxy.motion {
                ProxyMotion::Free { mass, inertia } => {
                    codec::finite("a body in reach", &[*mass])?;
                    codec::finite("a body in reach", inertia.as_slice())?;
                }
                ProxyMotion::Steady => {}
                ProxyMotion::Led(poses) => {
                    let have = poses.len();
                    if have != *steps as usize {
                        let (what, need) = ("poses of a led body", *steps as usize);
                        return Err(WireError::Short { what, have, need });
                    }
                    poses.iter().try_for_each(poses::check)?;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
