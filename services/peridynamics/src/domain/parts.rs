//! Parts of a body that move as wholes of their own.

use crate::frame::CorotatedFrame;
use cullet_geometry::Vec3;
use nalgebra::Rotation3;

/// Which points move together.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct MovingParts {
    /// Part of each point, by their first points; empty where the body is one.
    of: Vec<u32>,
    /// Points of each, ascending.
    members: Vec<Vec<u32>>,
}

/// Where each part of a body is and how it is turned.
#[derive(Clone, Debug)]
pub(super) struct PartFrames<'a> {
    frames: Vec<CorotatedFrame>,
    of: &'a [u32],
}

impl MovingParts {
    /// The parts as `labels` say.
    pub(super) fn new(labels: &[u32]) -> Self {
        let most = labels.iter().max().map_or(0, |&label| label as usize + 1);
        let (mut names, mut made) = (vec![u32::MAX; most], Self::default());
        for (p, &label) in labels.iter().enumerate() {
            let name = &mut names[label as usize];
            if *name == u32::MAX {
                *name = made.members.len() as u32;
                made.members.push(Vec::new());
            }
            made.of.push(*name);
            made.members[*name as usize].push(p as u32);
        }
        made
    }

    /// Where they are. A part whose turn is not determined counts as not turned.
    pub(super) fn frames(&self, places: &[Vec3], reference: &[Vec3]) -> PartFrames<'_> {
        let still = Rotation3::identity();
        let frame = |members: &Vec<u32>| {
            if members.len() == places.len() {
                return CorotatedFrame::of(places, reference, &still);
            }
            let pick = |of: &[Vec3]| members.iter().map(|&p| of[p as usize]).collect::<Vec<_>>();
            CorotatedFrame::of(&pick(places), &pick(reference), &still)
        };
        PartFrames { frames: self.members.iter().map(frame).collect(), of: &self.of }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.members.is_empty()
    }
}

impl PartFrames<'static> {
    /// Of a body that is one.
    pub(super) fn one(frame: CorotatedFrame) -> Self {
        Self { frames: vec![frame], of: &[] }
    }
}

impl PartFrames<'_> {
    /// Of a point.
    pub(super) fn of(&self, point: usize) -> &CorotatedFrame {
        &self.frames[self.of.get(point).map_or(0, |&part| part as usize)]
    }
}
