//! A specimen on its way to a process that solves it, and what came out: the types of
//! `services/specimen`, checked.

mod check;
mod result;

pub use crate::bounds::{MAX_FAMILY, MAX_FRAMES, MAX_PROBES, MAX_SAMPLES};
pub use cullet_specimen::{
    Amplitude, Ending, Frame, Hold, InitialState, Load, LoadKind, Matter, Notch, Output,
    PointField, PointLayout, PointSettings, Probe, Reduce, SpecimenBody, SpecimenOutcome,
    SpecimenProblem, SpecimenSettings, Spot, Start, StrengthPatch, SymmetryPlane, TensorPart,
    Where, Zone,
};
pub use result::{Price, SpecimenResult};

use crate::codec::WireError;
use crate::envelope::{self, MessageKind};
use crate::ids::JobId;
use crate::mesh::{self, Slabs};
use cullet_geometry::Solid;

/// A problem, and vertices and triangles of its mesh.
type SpecimenHeader = (SpecimenProblem, u32, u32);

/// A specimen to be solved.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecimenJob(pub SpecimenProblem);

impl SpecimenJob {
    /// The canonical bytes: equal specimens give equal bytes.
    ///
    /// # Errors
    /// The limit of the wire that it breaks.
    pub fn encode(&self) -> Result<Vec<u8>, WireError> {
        let solid = Solid::outer(self.0.body.mesh.clone());
        let (vertices, triangles) = mesh::counts(&solid)?;
        check::check(&self.0, triangles)?;
        let mut slabs = Vec::new();
        mesh::put_solid(&mut slabs, &solid);
        let header = (&self.0, vertices, triangles);
        match self.0.settings.horizon {
            // As it was before there was one.
            None => envelope::seal(MessageKind::Specimen, &header, &slabs),
            Some(horizon) => {
                envelope::seal(MessageKind::HorizonSpecimen, &(header, horizon), &slabs)
            }
        }
    }

    /// Whether these bytes hold a specimen, and no body to be broken.
    #[must_use]
    pub fn is(bytes: &[u8]) -> bool {
        envelope::is(MessageKind::Specimen, bytes)
            || envelope::is(MessageKind::HorizonSpecimen, bytes)
    }

    /// The specimen in these bytes.
    ///
    /// # Errors
    /// The first thing wrong with them, with the bound.
    pub fn decode(bytes: &[u8]) -> Result<Self, WireError> {
        let (header, horizon, slabs) = if envelope::is(MessageKind::HorizonSpecimen, bytes) {
            let kind = MessageKind::HorizonSpecimen;
            let ((header, horizon), slabs) = envelope::open::<(SpecimenHeader, f64)>(kind, bytes)?;
            (header, Some(horizon), slabs)
        } else {
            let (header, slabs) = envelope::open::<SpecimenHeader>(MessageKind::Specimen, bytes)?;
            (header, None, slabs)
        };
        let (mut problem, vertices, triangles) = header;
        problem.settings.horizon = horizon;
        check::check(&problem, triangles)?;
        let mut slabs = Slabs::new(slabs);
        problem.body.mesh = slabs.solid(vertices, triangles)?.mesh;
        slabs.end("a specimen")?;
        Ok(Self(problem))
    }

    /// The digest of [`SpecimenJob::encode`], whatever the number of threads.
    ///
    /// # Errors
    /// As [`SpecimenJob::encode`].
    pub fn id(&self) -> Result<JobId, WireError> {
        let mut same = self.clone();
        same.0.settings.threads = 1;
        Ok(JobId::of(&same.encode()?))
    }
}

#[cfg(test)]
mod tests;
