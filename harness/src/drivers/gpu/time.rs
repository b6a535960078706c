//! Times of frames: by the wall clock, and by the driver's time stamps if it has them.
//!
//! Time stamps are taken around render passes: around compute passes some software drivers return invented numbers.

use std::time::{Duration, Instant};

use diffraction_shaders::error::Result;

use super::guard::lock;
use super::readback::read_buffer;
use super::render::{Pipeline, Target};

/// Size of the two time stamps in bytes.
const STAMP_BYTES: u64 = 16;

/// Time of several frames together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameTimes {
    /// From submission until the device has finished.
    pub wall: Duration,
    /// From the beginning of the first pass to the end of the last, by the device's clock; `None` without time stamps.
    pub stamps: Option<Duration>,
}

impl Pipeline {
    /// Draws one frame, without reading it back, and returns the time from its submission to its end.
    pub fn time(&self, width: u32, height: u32, uniform: &[u8]) -> Result<Duration> {
        self.frames(width, height, uniform, 1).map(|times| times.wall)
    }

    /// Draws `count` frames in one submission, without reading them back. The caller must check whether the time stamps are
    /// plausible.
    pub fn frames(
        &self,
        width: u32,
        height: u32,
        uniform: &[u8],
        count: usize,
    ) -> Result<FrameTimes> {
        self.check(width, height, uniform)?;
        let target = self.target(width, height)?;
        let times =
            self.shared.guarded(&self.name, || self.submit(&target, height, uniform, count))?;
        *lock(&self.kept) = Some(target);
        Ok(times)
    }

    fn submit(
        &self,
        target: &Target,
        height: u32,
        uniform: &[u8],
        count: usize,
    ) -> Result<FrameTimes> {
        let queries = Queries::new(&self.shared.device);
        let mut encoder = self.encoder(uniform);
        for frame in 0..count {
            let stamps = queries.as_ref().map(|queries| wgpu::RenderPassTimestampWrites {
                query_set: &queries.set,
                beginning_of_pass_write_index: (frame == 0).then_some(0),
                end_of_pass_write_index: (frame + 1 == count).then_some(1),
            });
            // wgpu refuses a pass that writes no time stamp
            let stamps = stamps.filter(|_| frame == 0 || frame + 1 == count);
            self.pass(&mut encoder, target, 0..height, stamps);
        }
        if let Some(queries) = &queries {
            encoder.resolve_query_set(&queries.set, 0..2, &queries.resolved, 0);
            encoder.copy_buffer_to_buffer(&queries.resolved, 0, &queries.read, 0, STAMP_BYTES);
        }
        let commands = encoder.finish();
        let begun = Instant::now();
        let submission = self.shared.queue.submit([commands]);
        self.shared.wait(&self.name, &submission)?;
        let wall = begun.elapsed();
        let stamps = match &queries {
            Some(queries) => self.elapsed(queries, &submission)?,
            None => None,
        };
        Ok(FrameTimes { wall, stamps })
    }

    /// The time between the two time stamps; `None` if they run backwards.
    fn elapsed(
        &self,
        queries: &Queries,
        submission: &wgpu::SubmissionIndex,
    ) -> Result<Option<Duration>> {
        let read = (&queries.read, submission);
        let ticks = read_buffer(&self.shared, &self.name, "the time stamps", read, |bytes| {
            bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned::<u64>).collect::<Vec<_>>()
        })?;
        let period_ns = f64::from(self.shared.queue.get_timestamp_period());
        let between =
            ticks.last().zip(ticks.first()).and_then(|(last, first)| last.checked_sub(*first));
        Ok(between.map(|ticks| Duration::from_nanos((ticks as f64 * period_ns) as u64)))
    }
}

/// Two time stamps and the buffers to read them back.
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    read: wgpu::Buffer,
}

impl Queries {
    /// `None` if the device has no time stamps.
    fn new(device: &wgpu::Device) -> Option<Queries> {
        if !device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let label = Some("time stamps");
        let buffer = |usage| {
            let descriptor = wgpu::BufferDescriptor {
                label,
                size: STAMP_BYTES,
                usage,
                mapped_at_creation: false,
            };
            device.create_buffer(&descriptor)
        };
        Some(Queries {
            set: device.create_query_set(&wgpu::QuerySetDescriptor {
                label,
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
            read: buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
        })
    }
}
