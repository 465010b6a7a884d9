//! Mesh pipelines: a mesh shader that proposes fragments and a fragment shader that decides; no attachments.

use super::{Device, VulkanError};
use ash::vk;
use std::io::Cursor;
use std::sync::Arc;

/// Bytes that shaders are told at each draw; devices have room for 128 at least.
pub(super) const PUSH_BYTES: u32 = size_of::<Push>() as u32;

/// What shaders are told at each draw: `push` of vk_shaders/geometry.glsl.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(super) struct Push {
    pub patches: u64,
    pub leaves: u64,
    pub meshlets: u64,
    pub vertices: u64,
    /// A job a workgroup: the number of a meshlet, and above it which 32 of its items.
    pub numbers: u64,
    pub near: u64,
    pub spare: u64,
    pub trims: u64,
    /// First of `numbers`, the end of those that are drawn, and how many meshlets there are.
    pub first: u32,
    pub count: u32,
    pub all: u32,
    pub size: [u32; 2],
    /// Pixel in the viewport's middle, and half the viewport's side.
    pub middle: [i32; 2],
    pub half_viewport: i32,
    /// One over that.
    pub scale: f32,
}

const _: () = assert!(PUSH_BYTES <= 128);

/// What is drawn of each meshlet. Numbers are those of vk_shaders/outlines.glsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Triangles, with the vertices they share.
    Triangles = 5,
    /// One by one: those that reach beyond the viewport.
    Far = 0,
    /// Into the spare buffer.
    Borders = 1,
    Folds = 2,
    TurnedAway = 3,
    Conservative = 4,
}

const KINDS: [Kind; 6] = [Kind::Triangles, Kind::Far, Kind::Borders, Kind::Folds, Kind::TurnedAway, Kind::Conservative];

/// A pipeline for each kind of what no trim curve crosses, and, once they are asked for, of what curves cross.
pub(super) struct Pipelines {
    device: Arc<Device>,
    pub layout: vk::PipelineLayout,
    modules: Vec<vk::ShaderModule>,
    all: [Vec<vk::Pipeline>; 2],
}

const SHADERS: [&[u8]; 4] = [
    include_bytes!("../../vk_shaders/meshlet.mesh.spv"),
    include_bytes!("../../vk_shaders/meshlet.frag.spv"),
    include_bytes!("../../vk_shaders/outlines.mesh.spv"),
    include_bytes!("../../vk_shaders/outlines.frag.spv"),
];

impl Pipelines {
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let ranges = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::MESH_EXT | vk::ShaderStageFlags::FRAGMENT)
            .size(PUSH_BYTES)];
        let info = vk::PipelineLayoutCreateInfo::default().push_constant_ranges(&ranges);
        // SAFETY: `info` is valid and the device is alive.
        let layout = unsafe { device.raw.create_pipeline_layout(&info, None) };
        let layout = layout.map_err(VulkanError::of("vkCreatePipelineLayout"))?;
        let mut pipelines = Self { device: device.clone(), layout, modules: Vec::new(), all: Default::default() };
        for code in SHADERS {
            let module = pipelines.module(code)?;
            pipelines.modules.push(module);
        }
        pipelines.make(false)?;
        Ok(pipelines)
    }

    /// Makes those that are not there yet.
    pub fn make(&mut self, trimmed: bool) -> Result<(), VulkanError> {
        while let Some(&kind) = KINDS.get(self.all[usize::from(trimmed)].len()) {
            let pipeline = self.pipeline(kind, trimmed)?;
            self.all[usize::from(trimmed)].push(pipeline);
        }
        Ok(())
    }

    /// One that `make` has made.
    pub fn of(&self, kind: Kind, trimmed: bool) -> vk::Pipeline {
        let place = KINDS.iter().position(|k| *k == kind);
        place.and_then(|k| self.all[usize::from(trimmed)].get(k)).copied().unwrap_or_default()
    }

    fn module(&self, code: &[u8]) -> Result<vk::ShaderModule, VulkanError> {
        let words = ash::util::read_spv(&mut Cursor::new(code)).unwrap_or_default();
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: what glslang wrote of vk_shaders/, which tests/shaders.rs keeps fresh.
        unsafe { self.device.raw.create_shader_module(&info, None) }.map_err(VulkanError::of("vkCreateShaderModule"))
    }

    fn pipeline(&self, kind: Kind, trimmed: bool) -> Result<vk::Pipeline, VulkanError> {
        let first = if kind == Kind::Triangles { 0 } else { 2 };
        // KIND and TRIMMED.
        let entry = |id| vk::SpecializationMapEntry::default().constant_id(id).offset(4 * id).size(4);
        let entries = [entry(0), entry(1)];
        let constants: Vec<u8> = [kind as u32, u32::from(trimmed)].into_iter().flat_map(u32::to_ne_bytes).collect();
        let special = vk::SpecializationInfo::default().map_entries(&entries).data(&constants);
        let stage = |stage, module| {
            let info = vk::PipelineShaderStageCreateInfo::default().stage(stage).module(module).name(c"main");
            info.specialization_info(&special)
        };
        let stages = [
            stage(vk::ShaderStageFlags::MESH_EXT, self.modules[first]),
            stage(vk::ShaderStageFlags::FRAGMENT, self.modules[first + 1]),
        ];
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        // Both sides: what faces away is known exactly, and only where a solid is closed does it matter.
        let raster = vk::PipelineRasterizationStateCreateInfo::default().line_width(1.0);
        let samples =
            vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let mut rendering = vk::PipelineRenderingCreateInfo::default();
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .dynamic_state(&dynamic)
            .layout(self.layout)
            .push_next(&mut rendering);
        // SAFETY: all that `info` points to lives until the call returns.
        let made = unsafe { self.device.raw.create_graphics_pipelines(vk::PipelineCache::null(), &[info], None) };
        let made = made.map_err(|(_, code)| VulkanError::of("vkCreateGraphicsPipelines")(code))?;
        Ok(made[0])
    }
}

impl Drop for Pipelines {
    fn drop(&mut self) {
        // SAFETY: the device is done with them: `Rasterizer` waits for all that it has asked for.
        unsafe {
            self.all.iter().flatten().for_each(|pipeline| self.device.raw.destroy_pipeline(*pipeline, None));
            self.modules.iter().for_each(|module| self.device.raw.destroy_shader_module(*module, None));
            self.device.raw.destroy_pipeline_layout(self.layout, None);
        }
    }
}
