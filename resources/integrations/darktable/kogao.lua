-- Kogao for darktable: two buttons among the actions on selected images. Each photo goes out as a
-- TIFF of 16 bits, and the result comes back beside it, grouped with it.
-- Installed by `kogao-cli integrate darktable`, which fills in where the programs lie, and words.

local dt = require "darktable"

-- Within a Flatpak: out of its sandbox, whose /tmp nobody else sees; its cache is a usual folder.
local SANDBOXED = os.getenv("FLATPAK_ID") ~= nil
local OUT = SANDBOXED and "flatpak-spawn --host " or ""
local FOLDER = SANDBOXED and os.getenv("XDG_CACHE_HOME") or dt.configuration.tmp_dir
local EDITOR = OUT .. "@KOGAO@ --edit --temporary"
local BY_ITSELF = OUT .. "@KOGAO_CLI@ warp --in-place --temporary"
local CANCELLED = 6

local function quoted(path)
  if dt.configuration.running_os == "windows" then
    return '"' .. path .. '"'
  end
  return "'" .. path:gsub("'", "'\\''") .. "'"
end

local function is_there(path)
  local file = io.open(path, "rb")
  if file then
    file:close()
  end
  return file ~= nil
end

-- A name in a folder that nobody has yet.
local function free_name(folder, image, mark)
  local stem = folder .. "/" .. image.filename:gsub("%.[^.]*$", "") .. mark
  local name, number = stem .. ".tif", 1
  while is_there(name) do
    name, number = stem .. "_" .. number .. ".tif", number + 1
  end
  return name
end

local function copied(from, to)
  local source = assert(io.open(from, "rb"))
  local data = source:read("a")
  source:close()
  local target = assert(io.open(to, "wb"))
  target:write(data)
  target:close()
end

-- Run a command on a file, and return its exit code and the last line that it complained with.
local function run(command, file)
  local said = file .. ".said"
  local code = dt.control.execute(command .. " " .. quoted(file) .. " 2>" .. quoted(said))
  if code > 255 then -- as POSIX systems tell it
    code = code // 256
  end
  local last = ""
  if is_there(said) then
    for line in io.lines(said) do
      last = line:match("%S") and line or last
    end
    os.remove(said)
  end
  local at = last:find(FOLDER .. "/", 1, true)
  if at then
    last = last:sub(1, at - 1) .. last:sub(at + #FOLDER + 1)
  end
  return code, last
end

local function bring_back(image, file)
  local name = free_name(image.path, image, "_kogao")
  copied(file, name)
  local result = dt.database.import(name)
  result:group_with(image.group_leader)
  result.rating = image.rating
  for _, tag in ipairs(image:get_tags()) do
    if not tag.name:match("^darktable|") then
      result:attach_tag(tag)
    end
  end
end

-- Send photos out one by one; those that nothing was saved of stay as they are, without a word.
local function work_on(command, images)
  for _, image in ipairs(images) do
    local file = free_name(FOLDER, image, "")
    local format = dt.new_format("tiff")
    format.bpp = 16
    format:write_image(image, file)
    local code, complaint = run(command, file)
    if code == 0 then
      bring_back(image, file)
    elseif code ~= CANCELLED then
      dt.print(complaint ~= "" and complaint or "Kogao: " .. code)
    end
    os.remove(file)
  end
end

local function register(name, label, command)
  dt.gui.libs.image.register_action(name, label, function(_, images)
    work_on(command, images)
  end, "@RESULT_BESIDE@")
end

register("kogao_editor", "@EDIT@", EDITOR)
register("kogao_by_itself", "@SMALLER@", BY_ITSELF)

return { work_on = work_on, EDITOR = EDITOR, BY_ITSELF = BY_ITSELF }
