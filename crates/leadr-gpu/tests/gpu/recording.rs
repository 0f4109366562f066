//! Tests that recordings run ahead, keep their objects alive, are submitted once, and change nothing before submission.

use leadr_gpu::{
    Buffer, CommandRecorder, Commands, ComputePipeline, Descriptor, GpuError, Image, ImageDesc, Memory, Result,
    SharedStruct, Timestamps, Use, vk,
};

use leadr_testing::gpu::{Count, TestGpu, test_gpu};

fn doubling(gpu: &TestGpu) -> ComputePipeline {
    ComputePipeline::new(gpu, "probes/selftest/selftest.comp", &[], &[Count::LAYOUT]).unwrap()
}

fn record_double(cmd: &mut Commands, double: &ComputePipeline, from: &Buffer, to: &Buffer) {
    cmd.full_barrier();
    cmd.bind(double, &[("In", Descriptor::Storage(from)), ("Out", Descriptor::Storage(to))]);
    cmd.push_constants(&Count { count: 64 });
    cmd.dispatch([1, 1, 1]);
}

#[test]
fn recorder_keeps_resources_alive() {
    let Some(gpu) = test_gpu() else { return };
    let double = doubling(&gpu);
    let buffers: Vec<Buffer> =
        (0..5).map(|i| Buffer::from_slice(&gpu, &format!("b{i}"), &[1.0f32; 64]).unwrap()).collect();
    let mut ring: Vec<CommandRecorder> =
        (0..2).map(|i| CommandRecorder::new(&gpu, &format!("frame {i}")).unwrap()).collect();
    for frame in 0..4 {
        let recorder = &mut ring[frame % 2];
        recorder
            .record("frame", |cmd| {
                // The CPU drops this buffer while the device still uses it.
                let lost = Buffer::new(&gpu, "lost", 256, Memory::Device).unwrap();
                cmd.fill_buffer(&lost, 0);
                record_double(cmd, &double, &buffers[frame], &buffers[frame + 1]);
            })
            .unwrap();
        recorder.submit(&[], &[]).unwrap();
    }
    assert_eq!(buffers[4].read_all::<f32>().unwrap(), [16.0; 64]);
}

#[test]
fn a_recording_is_submitted_once() {
    let Some(gpu) = test_gpu() else { return };
    let double = doubling(&gpu);
    let [from, to] = ["from", "to"].map(|name| Buffer::from_slice(&gpu, name, &[1.0f32; 64]).unwrap());
    let mut recorder = CommandRecorder::new(&gpu, "frame").unwrap();
    let refused = |result: Result<()>| {
        let error = result.unwrap_err().to_string();
        assert!(error.contains("frame") && error.contains("record first"), "{error}");
    };
    refused(recorder.submit(&[], &[]));
    recorder.record("frame", |cmd| record_double(cmd, &double, &from, &to)).unwrap();
    recorder.submit(&[], &[]).unwrap();
    // A recording cannot be submitted again, whether it is pending or done.
    refused(recorder.submit(&[], &[]));
    recorder.wait().unwrap();
    refused(recorder.submit(&[], &[]));
    let failed = recorder.record("frame", |cmd| cmd.dispatch([1, 1, 1]));
    assert!(failed.is_err());
    refused(recorder.submit(&[], &[]));
    // A rejected submission does no harm.
    recorder.record("frame", |cmd| record_double(cmd, &double, &to, &from)).unwrap();
    recorder.submit(&[], &[]).unwrap();
    recorder.wait().unwrap();
    assert_eq!(from.read_all::<f32>().unwrap(), [4.0; 64]);
}

#[test]
fn image_layouts_follow_submission_order() {
    let Some(gpu) = test_gpu() else { return };
    let desc = ImageDesc::new(vk::Format::R32_SFLOAT, 4, 4).storage();
    let image = Image::new(&gpu, "image", desc).unwrap();
    let texels: Vec<f32> = (0..16u8).map(f32::from).collect();
    image.write(0, 0, &texels).unwrap();
    let refused = gpu.submit("refused", |cmd| {
        cmd.transition(&image, Use::ComputeReadWrite);
        cmd.fail(GpuError::Usage { name: "test".to_owned(), fault: "refused on purpose".to_owned() });
    });
    assert!(refused.is_err());
    // With the wrong layout, the barrier of this read would trigger a validation message.
    assert_eq!(image.read::<f32>(0, 0).unwrap(), texels);
    let mut dropped = CommandRecorder::new(&gpu, "dropped").unwrap();
    dropped.record("never submitted", |cmd| cmd.transition(&image, Use::ComputeReadWrite)).unwrap();
    assert_eq!(image.read::<f32>(0, 0).unwrap(), texels);
    gpu.assert_silent();
    // Within a recording, each barrier starts from the image's last use.
    gpu.submit("there and back", |cmd| {
        cmd.transition(&image, Use::ComputeReadWrite);
        cmd.transition(&image, Use::CopySource);
        cmd.transition(&image, Use::Sampled);
    })
    .unwrap();
    assert_eq!(image.read::<f32>(0, 0).unwrap(), texels);
}

/// Tests that marks of commands that were never submitted cannot block a reader.
#[test]
fn timestamps_follow_submission() {
    let Some(gpu) = test_gpu() else { return };
    let timestamps = Timestamps::new(&gpu, 4).unwrap();
    let mark = |names: &[&str], misuse: bool| {
        gpu.submit("marks", |cmd| {
            cmd.reset_timestamps(&timestamps);
            names.iter().for_each(|name| cmd.timestamp(&timestamps, name));
            if misuse {
                cmd.dispatch([1, 1, 1]);
            }
        })
    };
    mark(&["start", "end"], false).unwrap();
    assert!(mark(&["one", "two", "three"], true).is_err());
    let names: Vec<String> = timestamps.marks().unwrap().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["start", "end"]);
    let error = gpu.submit("no reset", |cmd| cmd.timestamp(&timestamps, "late")).unwrap_err().to_string();
    assert!(error.contains("not reset"), "{error}");
}

/// Without the label lock, creating command buffers crashed the validation layer of Debian 12 in 5 of 40 runs.
#[test]
fn threads_upload_side_by_side() {
    let Some(gpu) = test_gpu() else { return };
    std::thread::scope(|scope| {
        for thread in 0..3 {
            let gpu = gpu.clone();
            scope.spawn(move || {
                for n in 0..2000u32 {
                    let buffer = Buffer::from_slice(&gpu, &format!("thread {thread} {n}"), &[n; 16]).unwrap();
                    assert_eq!(buffer.read::<u32>(0, 1).unwrap(), [n]);
                }
            });
        }
    });
    gpu.assert_silent();
}
