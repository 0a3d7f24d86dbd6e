// SPDX-License-Identifier: MIT
// dermis: pressure on skin in, mechanoreceptor responses out.
//
//     dermis::Result r = dermis::run(dermis::Scene::from_file("scene.toml"));
//
// This header is all of the library but Vulkan recording (vulkan.hpp), contacts (contact.hpp) and fits (fit.hpp). What
// embeds in a simulator needs no scene: skin.hpp, on the library dermis::core alone.
#pragma once

#include <dermis/description.hpp>
#include <dermis/device.hpp>
#include <dermis/run.hpp>
#include <dermis/scene.hpp>
#include <dermis/skin.hpp>
#include <dermis/version.hpp>
