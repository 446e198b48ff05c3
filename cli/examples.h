#pragma once
#include <string>
#include <vector>

/// Commands that show a verb at work, a line each: with its help, in the man page. @param path "inhabit eval forecast"
std::vector<std::string> examples_of(const std::string& path);
