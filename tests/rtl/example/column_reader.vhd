-- Reads the packets of a board: a design of a user in VHDL-2008, behind the AXI4-Stream of sp_board.
--
-- It gives the columns of packets of kind moments that measure all lit pixels (select all), in all modes, one a clock,
-- and at the end of each packet whether its frame was good. Of packets of other kinds it gives nothing but their end.
--
--   clk_i           _/-\_/-\_/-\_/-\_/-\_/-\_/-\_
--   s_axis_tvalid   ____/-------\________________
--   s_axis_tready   ------------\___________/----   low while the columns of a beat leave
--   column_valid_o  ____________/-----------\____   two (grey modes) or four columns of that beat
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

library work;
use work.sp_spec_pkg.all;

entity column_reader is
  port (
    clk_i          : in  std_ulogic;
    rst_i          : in  std_ulogic;  -- synchronous, active high

    s_axis_tvalid  : in  std_ulogic;
    s_axis_tready  : out std_ulogic;
    s_axis_tdata   : in  std_ulogic_vector(127 downto 0);
    s_axis_tlast   : in  std_ulogic;

    column_valid_o : out std_ulogic;
    column_m0_o    : out unsigned(GreyM0Bits - 1 downto 0);
    column_m1_o    : out unsigned(GreyM1Bits - 1 downto 0);
    done_o         : out std_ulogic;  -- high for a clock behind the last beat of a packet
    good_o         : out std_ulogic   -- with done_o: the frame was complete and right
  );
end entity;

architecture rtl of column_reader is

  constant HeaderBeats : natural := HeaderBits / 128;
  -- A field of the header is taken from the beat in which it lies.
  constant KindBeat    : natural := HeaderKindLsb / 128;
  constant KindLsb     : natural := HeaderKindLsb mod 128;
  constant ModeBeat    : natural := HeaderModeLsb / 128;
  constant ModeLsb     : natural := HeaderModeLsb mod 128;
  constant SelectBeat  : natural := HeaderSelectLsb / 128;
  constant SelectLsb   : natural := HeaderSelectLsb mod 128;
  constant CountBeat   : natural := HeaderColumnsLsb / 128;
  constant CountLsb    : natural := HeaderColumnsLsb mod 128;

  signal beat_q    : natural range 0 to HeaderBeats := 0;  -- of the header; HeaderBeats behind it
  signal ours_q    : boolean := false;                     -- kind moments, select all
  signal binary_q  : boolean := false;
  signal columns_q : unsigned(HeaderColumnsBits - 1 downto 0) := (others => '0');  -- still to come in this packet
  signal words_q   : std_ulogic_vector(127 downto 0) := (others => '0');           -- the next column lowest
  signal left_q    : natural range 0 to 4 := 0;                                    -- columns in words_q

begin

  s_axis_tready  <= '1' when left_q = 0 else '0';
  column_valid_o <= '1' when left_q /= 0 else '0';
  column_m0_o    <= resize(unsigned(words_q(BinaryM0Lsb + BinaryM0Bits - 1 downto BinaryM0Lsb)), GreyM0Bits)
                    when binary_q else unsigned(words_q(GreyM0Lsb + GreyM0Bits - 1 downto GreyM0Lsb));
  column_m1_o    <= resize(unsigned(words_q(BinaryM1Lsb + BinaryM1Bits - 1 downto BinaryM1Lsb)), GreyM1Bits)
                    when binary_q else unsigned(words_q(GreyM1Lsb + GreyM1Bits - 1 downto GreyM1Lsb));

  process (clk_i)
    variable here   : natural range 0 to 4;  -- columns in a beat
    variable status : unsigned(TrailerStatusBits - 1 downto 0);
  begin
    if rising_edge(clk_i) then
      done_o <= '0';
      if left_q /= 0 then
        left_q <= left_q - 1;
        if binary_q then
          words_q <= std_ulogic_vector(shift_right(unsigned(words_q), BinaryWordBits));
        else
          words_q <= std_ulogic_vector(shift_right(unsigned(words_q), GreyWordBits));
        end if;
      elsif s_axis_tvalid = '1' then
        if beat_q = KindBeat then
          ours_q <= s_axis_tdata(KindLsb + HeaderKindBits - 1 downto KindLsb) = KindMoments;
        end if;
        if beat_q = ModeBeat then
          binary_q <= s_axis_tdata(ModeLsb + ModeBits - 1 downto ModeLsb) = ModeBinary;
        end if;
        if beat_q = SelectBeat and s_axis_tdata(SelectLsb + SelectBits - 1 downto SelectLsb) /= SelectAll then
          ours_q <= false;
        end if;
        if beat_q = CountBeat then
          columns_q <= unsigned(s_axis_tdata(CountLsb + HeaderColumnsBits - 1 downto CountLsb));
        end if;
        if beat_q < HeaderBeats then
          beat_q <= beat_q + 1;
        elsif s_axis_tlast = '0' and ours_q then
          here := 4 when binary_q else 2;
          if columns_q < here then
            here := to_integer(columns_q(2 downto 0));
          end if;
          words_q   <= s_axis_tdata;
          left_q    <= here;
          columns_q <= columns_q - here;
        end if;
        if s_axis_tlast = '1' then
          beat_q <= 0;
          done_o <= '1';
          status := unsigned(s_axis_tdata(TrailerStatusLsb + TrailerStatusBits - 1 downto TrailerStatusLsb));
          good_o <= '1' when status = 0 else '0';
        end if;
      end if;
      if rst_i = '1' then
        beat_q <= 0;
        left_q <= 0;
        ours_q <= false;
        done_o <= '0';
      end if;
    end if;
  end process;

end architecture;
