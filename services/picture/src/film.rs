//! Animated GIF with one palette for all frames, so that a still background does not flicker, and
//! only the changed rectangle of each frame.

use super::picture::Picture;
use cullet_files::output::write_file;
use cullet_record::RecordError;
use std::borrow::Cow;
use std::path::Path;

/// Colours of the palette; one more stands for "as before".
const COLOURS: usize = 255;
/// The entry for "as before".
const SAME: u8 = 255;
/// Bits kept of each channel while colours are counted.
const BITS: u32 = 5;
/// Counted colours: 2^(3·5).
const BINS: usize = 1 << (3 * BITS);

/// A box of counted colours that becomes one colour of the palette.
struct ColourBox {
    bins: Vec<u32>,
    weight: u64,
}

fn bin(rgb: &[u8]) -> usize {
    let channel = |i: usize| usize::from(rgb[i] >> (8 - BITS));
    channel(0) << (2 * BITS) | channel(1) << BITS | channel(2)
}

fn channel(bin: u32, axis: u32) -> u32 {
    bin >> ((2 - axis) * BITS) & ((1 << BITS) - 1)
}

/// Median cut: the box of greatest weight times extent is halved until there are enough.
fn palette(frames: &[Picture]) -> (Vec<u8>, Vec<u8>) {
    let mut counts = vec![0_u64; BINS];
    let mut sums = vec![[0_u64; 3]; BINS];
    for frame in frames {
        for rgb in frame.rgb.chunks_exact(3) {
            let at = bin(rgb);
            counts[at] += 1;
            sums[at] = std::array::from_fn(|i| sums[at][i] + u64::from(rgb[i]));
        }
    }
    let used: Vec<u32> = (0..BINS as u32).filter(|&b| counts[b as usize] > 0).collect();
    let weight = used.iter().map(|&b| counts[b as usize]).sum();
    let mut boxes = vec![ColourBox { bins: used, weight }];
    while boxes.len() < COLOURS {
        let worth = |b: &ColourBox| {
            let (_, extent) = widest(&b.bins);
            // The root keeps small bright parts from losing to a large sky.
            f64::from(extent) * (b.weight as f64).sqrt()
        };
        let best = (0..boxes.len()).max_by(|&i, &j| worth(&boxes[i]).total_cmp(&worth(&boxes[j])));
        let Some(best) = best.filter(|&i| boxes[i].bins.len() > 1) else {
            break;
        };
        let (low, high) = halved(boxes.swap_remove(best), &counts);
        boxes.push(low);
        boxes.push(high);
    }
    let mut colours = Vec::with_capacity(768);
    let mut lookup = vec![0_u8; BINS];
    for (entry, share) in boxes.iter().enumerate() {
        let total = |i: usize| share.bins.iter().map(|&b| sums[b as usize][i]).sum::<u64>();
        colours.extend((0..3).map(|i| (total(i) / share.weight.max(1)) as u8));
        share.bins.iter().for_each(|&b| lookup[b as usize] = entry as u8);
    }
    colours.resize(768, 0);
    (colours, lookup)
}

/// The axis along which the bins spread furthest, and how far.
fn widest(bins: &[u32]) -> (u32, u32) {
    let extent = |axis: u32| {
        let along = || bins.iter().map(|&b| channel(b, axis));
        along().max().unwrap_or(0) - along().min().unwrap_or(0)
    };
    (0..3).map(|axis| (axis, extent(axis))).max_by_key(|&(_, e)| e).unwrap_or((0, 0))
}

fn halved(share: ColourBox, counts: &[u64]) -> (ColourBox, ColourBox) {
    let (axis, _) = widest(&share.bins);
    let mut bins = share.bins;
    bins.sort_by_key(|&b| (channel(b, axis), b));
    let mut below = 0;
    let mut at = 0;
    while at + 1 < bins.len() && (at == 0 || 2 * below < share.weight) {
        below += counts[bins[at] as usize];
        at += 1;
    }
    let high = bins.split_off(at);
    let weight = |bins: &[u32]| bins.iter().map(|&b| counts[b as usize]).sum();
    (ColourBox { weight: weight(&bins), bins }, ColourBox { weight: weight(&high), bins: high })
}

/// Writes frames of one size as a GIF that repeats: first beside its name, then under it.
///
/// # Errors
/// The file cannot be written, or there is no frame, or a frame is too large; nothing is left of it
/// then.
pub(super) fn gif(frames: &[Picture], fps: f64, path: &Path) -> Result<(), RecordError> {
    let fail = |reason: String| RecordError::Picture { path: path.to_owned(), reason };
    let first = frames.first().ok_or_else(|| fail("no frames".to_owned()))?;
    let size = |n: usize| u16::try_from(n).map_err(|_| fail(format!("{n} pixels are too many")));
    let (width, height) = (size(first.width)?, size(first.height)?);
    let (colours, lookup) = palette(frames);
    let mut bytes = Vec::new();
    let mut encoder =
        gif::Encoder::new(&mut bytes, width, height, &colours).map_err(|e| fail(e.to_string()))?;
    encoder.set_repeat(gif::Repeat::Infinite).map_err(|e| fail(e.to_string()))?;
    let delay = (100.0 / fps).round() as u16;
    let mut shown: Option<Vec<u8>> = None;
    for frame in frames {
        let pixels: Vec<u8> = frame.rgb.chunks_exact(3).map(|rgb| lookup[bin(rgb)]).collect();
        let drawn = changed(shown.as_deref(), &pixels, (first.width, first.height));
        encoder.write_frame(&gif::Frame { delay, ..drawn }).map_err(|e| fail(e.to_string()))?;
        shown = Some(pixels);
    }
    drop(encoder);
    write_file(path, &bytes).map_err(RecordError::io(path))
}

/// The rectangle in which a frame differs from the one shown.
fn changed(
    shown: Option<&[u8]>,
    pixels: &[u8],
    (width, height): (usize, usize),
) -> gif::Frame<'static> {
    let differs = |i: usize| shown.is_none_or(|s| s[i] != pixels[i]);
    let rows: Vec<usize> =
        (0..height).filter(|y| (0..width).any(|x| differs(y * width + x))).collect();
    let columns: Vec<usize> =
        (0..width).filter(|x| rows.iter().any(|y| differs(y * width + x))).collect();
    let span = |along: &[usize]| match (along.first(), along.last()) {
        (Some(&first), Some(&last)) => (first, last + 1),
        _ => (0, 1),
    };
    let ((top, bottom), (left, right)) = (span(&rows), span(&columns));
    let mut buffer = Vec::with_capacity((bottom - top) * (right - left));
    for y in top..bottom {
        let row = y * width + left..y * width + right;
        buffer.extend(row.map(|i| if differs(i) { pixels[i] } else { SAME }));
    }
    gif::Frame {
        left: left as u16,
        top: top as u16,
        width: (right - left) as u16,
        height: (bottom - top) as u16,
        buffer: Cow::Owned(buffer),
        transparent: shown.is_some().then_some(SAME),
        dispose: gif::DisposalMethod::Keep,
        ..gif::Frame::default()
    }
}
