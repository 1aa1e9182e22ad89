//! The windows of a database with gradient signatures, as they are searched and compared: 150 bytes of each.

use std::sync::Arc;

use super::description::{MOST_LEVELS, ScaleSpaceDescriber};
use super::phase_space::{KEPT_LENGTH, PhaseSpace};
use super::window_space::EncodedExemplar;
use crate::column::Column;
use crate::eigen::inverted_index::fine_length;
use crate::eigen::{Codebook, Codes, InvertedIndex, Segment, SegmentColumns};
use crate::recognition::landmarks::model::Exemplar;

/// Segments of a database at most: each costs a query a little.
const MOST_SEGMENTS: usize = 8;

/// Windows of exemplars that were taught together, as they are kept. n is their number.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentParts {
    /// Their eigenpoints.
    pub lists: SegmentColumns,
    /// n × 2: x and y of each window; the longer side of the exemplar at its working size is 65535.
    pub positions: Column<u16>,
    /// n: level of each window.
    pub levels: Column<u8>,
    /// n × 64: each window's phases.
    pub phases: Column<u8>,
    /// Where the windows of each of `exemplars` start, and after the last n.
    pub starts: Column<u32>,
    /// Indices of the database's exemplars, ascending.
    pub exemplars: Vec<u32>,
}

/// What a match needs of a window.
pub(super) struct EncodedWindow<'a> {
    /// Index of its exemplar.
    pub exemplar: u32,
    /// In units of the exemplar's size.
    pub position: [u16; 2],
    pub level: u8,
    pub phases: &'a [u8],
}

/// All windows of a database.
pub(in super::super) struct EncodedWindows {
    pub(super) describer: ScaleSpaceDescriber,
    pub phases: Arc<PhaseSpace>,
    index: InvertedIndex,
    segments: Vec<WindowSegment>,
}

/// Beside the eigenpoints of a segment of the index.
struct WindowSegment {
    /// Windows of the segments before.
    first: usize,
    positions: Column<u16>,
    levels: Column<u8>,
    phases: Column<u8>,
    starts: Column<u32>,
    exemplars: Vec<u32>,
}

impl SegmentParts {
    /// The windows of exemplars, one after the other.
    pub(in super::super) fn of(codebook: &Codebook, encoded: Vec<EncodedExemplar>) -> SegmentParts {
        let mut codes = Codes::default();
        let (mut positions, mut levels, mut phases, mut starts) = (vec![], vec![], vec![], vec![0]);
        let count = encoded.len() as u32;
        for mut exemplar in encoded {
            codes.lists.append(&mut exemplar.codes.lists);
            codes.codes.append(&mut exemplar.codes.codes);
            codes.fine.append(&mut exemplar.codes.fine);
            positions.append(&mut exemplar.positions);
            levels.append(&mut exemplar.levels);
            phases.append(&mut exemplar.phases);
            starts.push(levels.len() as u32);
        }
        SegmentParts {
            lists: Segment::new(codebook, &codes).columns(),
            positions: positions.into(),
            levels: levels.into(),
            phases: phases.into(),
            starts: starts.into(),
            exemplars: (0..count).collect(),
        }
    }

    /// Whether its windows are those of `exemplars`, on levels that there are.
    fn is_sound(&self, windows: usize, exemplars: &[Exemplar]) -> bool {
        let own = |(&exemplar, range): (&u32, &[u32])| {
            let count = (range[1] - range[0]) as usize;
            exemplars.get(exemplar as usize).is_some_and(|exemplar| exemplar.windows == count)
        };
        self.starts.len() == self.exemplars.len() + 1
            && self.starts.first() == Some(&0)
            && self.starts.is_sorted()
            && self.starts.last().is_some_and(|&end| end as usize == windows)
            && self.positions.len() == 2 * windows
            && self.levels.len() == windows
            && self.phases.len() == KEPT_LENGTH * windows
            && self.exemplars.is_sorted_by(|a, b| a < b)
            && self.exemplars.iter().zip(self.starts.windows(2)).all(own)
            && self.levels.iter().all(|&level| usize::from(level) < MOST_LEVELS)
    }
}

impl WindowSegment {
    /// The index of the exemplar of one of its windows.
    fn exemplar(&self, window: usize) -> u32 {
        self.exemplars[self.starts.partition_point(|&start| start as usize <= window) - 1]
    }
}

impl EncodedWindows {
    /// The windows of segments that may hold anything; `None` if they are not those of the exemplars, each once.
    pub fn of_parts(
        describer: ScaleSpaceDescriber,
        phases: Arc<PhaseSpace>,
        codebook: Arc<Codebook>,
        parts: Vec<SegmentParts>,
        exemplars: &[Exemplar],
    ) -> Option<EncodedWindows> {
        let mut owned: Vec<u32> = parts.iter().flat_map(|part| part.exemplars.iter().copied()).collect();
        owned.sort_unstable();
        if !owned.into_iter().eq(0..exemplars.len() as u32) {
            return None;
        }
        let (mut segments, mut of_index, mut first) = (Vec::new(), Vec::new(), 0_usize);
        for part in parts {
            let segment = Segment::of_columns(&codebook, part.lists.clone())?;
            let windows = segment.count();
            if !part.is_sound(windows, exemplars) {
                return None;
            }
            let SegmentParts { positions, levels, phases, starts, exemplars, .. } = part;
            segments.push(WindowSegment { first, positions, levels, phases, starts, exemplars });
            of_index.push(segment);
            first += windows;
        }
        let fits = first > 0 && first < u32::MAX as usize;
        fits.then(|| EncodedWindows {
            describer,
            phases,
            index: InvertedIndex::of_segments(codebook, of_index),
            segments,
        })
    }

    /// What they are kept as.
    pub fn parts(&self) -> Vec<SegmentParts> {
        let both = self.segments.iter().zip(self.index.segments());
        both.map(|(windows, eigenpoints)| SegmentParts {
            lists: eigenpoints.columns(),
            positions: windows.positions.clone(),
            levels: windows.levels.clone(),
            phases: windows.phases.clone(),
            starts: windows.starts.clone(),
            exemplars: windows.exemplars.clone(),
        })
        .collect()
    }

    /// What is kept of the exemplars of a segment, one by one.
    fn encoded(&self, segment: usize, exemplars: &[Exemplar]) -> Vec<EncodedExemplar> {
        let WindowSegment { positions, levels, phases, starts, exemplars: own, .. } = &self.segments[segment];
        let dimension = self.index.codebook().dimension();
        let codes = self.index.segments()[segment].codes(dimension);
        let encoded = |(&exemplar, range): (&u32, &[u32])| {
            let of = |numbers: usize| range[0] as usize * numbers..range[1] as usize * numbers;
            EncodedExemplar {
                exemplar: exemplars[exemplar as usize].clone(),
                codes: Codes {
                    lists: codes.lists[of(1)].to_vec(),
                    codes: codes.codes[of(dimension)].to_vec(),
                    fine: codes.fine[of(fine_length(dimension))].to_vec(),
                },
                positions: positions[of(2)].to_vec(),
                levels: levels[of(1)].to_vec(),
                phases: phases[of(KEPT_LENGTH)].to_vec(),
                energy: [0.0; 2],
            }
        };
        own.iter().zip(starts.windows(2)).map(encoded).collect()
    }

    /// The segments without the exemplars that aren't kept, and with one of those that are added, each with its exemplars. What
    /// isn't kept is nowhere in them. Of more than [`MOST_SEGMENTS`] all but the largest become one.
    pub fn regrouped(
        &self,
        exemplars: &[Exemplar],
        keeps: impl Fn(&Exemplar) -> bool,
        added: Vec<EncodedExemplar>,
    ) -> Vec<(SegmentParts, Vec<Exemplar>)> {
        let codebook = self.index.codebook();
        let of = |mut encoded: Vec<EncodedExemplar>| {
            encoded.sort_by(|a, b| a.exemplar.sort_key().cmp(&b.exemplar.sort_key()));
            let exemplars = encoded.iter_mut().map(|e| std::mem::take(&mut e.exemplar)).collect();
            (SegmentParts::of(codebook, encoded), exemplars)
        };
        let parts = self.parts();
        let largest = (0..parts.len()).max_by_key(|&number| parts[number].levels.len());
        let merges = parts.len() + usize::from(!added.is_empty()) > MOST_SEGMENTS;
        let (mut groups, mut loose) = (Vec::new(), added);
        for (number, part) in parts.into_iter().enumerate() {
            let own: Vec<&Exemplar> = part.exemplars.iter().map(|&e| &exemplars[e as usize]).collect();
            let is_whole = own.iter().all(|exemplar| keeps(exemplar));
            if is_whole && !(merges && Some(number) != largest) {
                let own = own.into_iter().cloned().collect();
                groups.push((part, own));
                continue;
            }
            let mut kept = self.encoded(number, exemplars);
            kept.retain(|encoded| keeps(&encoded.exemplar));
            match merges && Some(number) != largest {
                true => loose.append(&mut kept),
                false if !kept.is_empty() => groups.push(of(kept)),
                false => {}
            }
        }
        if !loose.is_empty() {
            groups.push(of(loose));
        }
        groups
    }

    pub fn index(&self) -> &InvertedIndex {
        &self.index
    }

    fn segment(&self, window: usize) -> (&WindowSegment, usize) {
        let after = self.segments.partition_point(|segment| segment.first <= window);
        let segment = &self.segments[after - 1];
        (segment, window - segment.first)
    }

    /// The index of a window's exemplar.
    pub fn exemplar(&self, window: usize) -> usize {
        let (segment, at) = self.segment(window);
        segment.exemplar(at) as usize
    }

    pub(super) fn window(&self, window: usize) -> EncodedWindow<'_> {
        let (segment, at) = self.segment(window);
        EncodedWindow {
            exemplar: segment.exemplar(at),
            position: [segment.positions[2 * at], segment.positions[2 * at + 1]],
            level: segment.levels[at],
            phases: &segment.phases[at * KEPT_LENGTH..][..KEPT_LENGTH],
        }
    }

    /// Memory that they take, mapped or not, in bytes.
    pub fn bytes(&self) -> usize {
        let own = |segment: &WindowSegment| {
            segment.positions.bytes()
                + segment.levels.bytes()
                + segment.phases.bytes()
                + segment.starts.bytes()
                + size_of_val(&segment.exemplars[..])
        };
        self.index.bytes() + size_of_val(self.phases.basis()) + self.segments.iter().map(own).sum::<usize>()
    }
}
