//! A window of the time of a body that moves as it deforms, on its way to a worker, and what came
//! of it.
//!
//! What is large in a job is its state and the corners of bodies in reach: each travels by its
//! digest, so that the worker that made a state need not be sent it.

mod outcome;

pub use outcome::{decode_outcome, encode_outcome, state_of};

use crate::codec::{self, WireError};
use crate::envelope::{self, MessageKind};
use crate::ids::{JobId, digest};
use crate::job::MAX_SOLVER;
use crate::mesh::{self, Slabs};
use cullet_geometry::Vec3;
use cullet_model::{ContinuumSetup, ProxyMotion, Window};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;

/// Most rigid bodies in one window: they travel in the header.
pub const MAX_PROXIES: usize = 160;
/// Most convex parts of a body in reach.
pub const MAX_PARTS_OF_PROXY: usize = 4_096;
/// Most steps of the rigid world in one window.
pub const MAX_WINDOW_STEPS: u64 = 1_024;
/// Largest state \[bytes\] (F96).
pub const MAX_STATE: u64 = 64 << 20;

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

#[derive(Serialize, Deserialize)]
struct WindowHeader {
    family: String,
    setup: ContinuumSetup,
    window: Window,
    /// Corners of each convex part of each body in reach.
    corners: Vec<Vec<u32>>,
    /// \[bytes\].
    state: Option<u64>,
}

impl WindowJob {
    /// The canonical bytes: equal windows give equal bytes.
    ///
    /// # Errors
    /// The limit of the wire that the window breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        Ok(self.slabs()?.0)
    }

    /// The canonical bytes, and where in them the corners and the state are.
    pub(crate) fn slabs(&self) -> Result<(Vec<u8>, [Range<usize>; 2]), WireError> {
        let count = |part: &Vec<Vec3>| part.len() as u32;
        let proxies = &self.window.proxies;
        let corners = proxies.iter().map(|proxy| proxy.parts.iter().map(count).collect());
        let header = WindowHeader {
            family: self.family.clone(),
            setup: self.setup.clone(),
            window: self.window.clone(),
            corners: corners.collect(),
            state: self.state.as_ref().map(|state| state.len() as u64),
        };
        header.check()?;
        let mut slabs = Vec::new();
        proxies.iter().flat_map(|p| &p.parts).for_each(|part| mesh::put_points(&mut slabs, part));
        let middle = slabs.len();
        slabs.extend_from_slice(self.state.as_ref().map_or(&[], |state| state.as_slice()));
        let bytes = envelope::seal(MessageKind::WindowJob, &header, &slabs)?;
        let first = bytes.len() - slabs.len();
        let (middle, last) = (first + middle, bytes.len());
        Ok((bytes, [first..middle, middle..last]))
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
        let (mut header, slabs) = envelope::open::<WindowHeader>(MessageKind::WindowJob, bytes)?;
        header.check()?;
        let mut slabs = Slabs::new(slabs);
        for (proxy, counts) in header.window.proxies.iter_mut().zip(&header.corners) {
            let part = |count: &u32| slabs.points("corners of a body in reach", *count as usize);
            proxy.parts = counts.iter().map(part).collect::<Result<_, _>>()?;
        }
        let state = match header.state {
            Some(length) => Some(slabs.take("a window's state", length as usize, 1)?.to_vec()),
            None => None,
        };
        slabs.end("a window")?;
        let WindowHeader { family, setup, window, .. } = header;
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
    /// [`WireError::Header`] if it is too large.
    pub fn setup_digest(&self) -> Result<[u8; 32], WireError> {
        Ok(digest(&codec::encode(&(&self.family, &self.setup))?))
    }
}

impl WindowHeader {
    fn check(&self) -> Result<(), WireError> {
        let Window { steps, frame_every, proxies, .. } = &self.window;
        codec::limit("a family name's length", self.family.len() as u64, MAX_SOLVER as u64)?;
        codec::limit("steps of a window", u64::from(*steps), MAX_WINDOW_STEPS)?;
        codec::limit("a window without steps", 1, u64::from(*steps))?;
        codec::limit("a window without frames", 1, u64::from(*frame_every))?;
        codec::limit("bodies in a window's reach", proxies.len() as u64, MAX_PROXIES as u64)?;
        codec::limit("bodies with corners", self.corners.len() as u64, proxies.len() as u64)?;
        codec::limit("bodies without corners", proxies.len() as u64, self.corners.len() as u64)?;
        codec::limit("a window's state", self.state.unwrap_or(0), MAX_STATE)?;
        codec::finite("a window's step", &[self.setup.world_step])?;
        codec::finite("a window's gravity", self.setup.gravity.as_slice())?;
        for (proxy, corners) in proxies.iter().zip(&self.corners) {
            let parts = corners.len() as u64;
            codec::limit("a body's convex parts", parts, MAX_PARTS_OF_PROXY as u64)?;
            let motion = [proxy.velocity.as_slice(), proxy.spin.as_slice()].concat();
            codec::finite("a body in reach", &motion)?;
            codec::finite("a body in reach", &[proxy.friction])?;
            pose(&proxy.pose)?;
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
                    poses.iter().try_for_each(pose)?;
                }
            }
        }
        Ok(())
    }
}

/// Holds a pose to finite numbers and a turn of length 1.
fn pose(pose: &cullet_geometry::Pose) -> Result<(), WireError> {
    codec::finite("a pose", pose.translation.vector.as_slice())?;
    codec::finite("a pose", pose.rotation.coords.as_slice())?;
    let off = (pose.rotation.coords.norm() - 1.0).abs();
    if off > 1e-6 {
        return Err(WireError::Header(format!("a turn is off length 1 by {off:.1e}")));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
